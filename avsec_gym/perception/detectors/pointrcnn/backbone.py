"""PointNet++ with several scales at each level: what each point knows of its surroundings."""

from __future__ import annotations

from torch import Tensor, nn

from avsec_gym.perception.detectors.pointrcnn.configuration import Level
from avsec_gym.perception.nn.point_layers import FeaturePropagation, SetAbstraction


class PointBackbone(nn.Module):
    """Fewer and fewer points, and back to all.

    Args:
        levels: Fine to coarse.
        propagation: Channels of the layers back up, fine to coarse.
    """

    def __init__(self, levels: tuple[Level, ...], propagation: tuple[tuple[int, ...], ...]) -> None:
        super().__init__()
        known = [0]
        self.SA_modules = nn.ModuleList()
        for level in levels:
            self.SA_modules.append(set_abstraction(known[-1], level))
            known.append(sum(channels[-1] for channels in level.channels))
        coarser = [channels[-1] for channels in propagation[1:]] + [known[-1]]
        self.FP_modules = nn.ModuleList(
            FeaturePropagation([below + own, *channels])
            for below, own, channels in zip(coarser, known, propagation, strict=False)
        )

    def forward(self, points: Tensor) -> Tensor:
        """Points (B, N, 3) to features (B, N, channels)."""
        places: list[Tensor] = [points]
        features: list[Tensor | None] = [None]
        for abstraction in self.SA_modules:
            place, feature = abstraction(places[-1], features[-1])
            places.append(place)
            features.append(feature)
        known = features[-1]
        for number in range(len(self.FP_modules) - 1, -1, -1):
            known = self.FP_modules[number](
                places[number], places[number + 1], features[number], known
            )
        assert known is not None, "there is at least one level"
        return known


def set_abstraction(inputs: int, level: Level, *, is_normalised: bool = True) -> SetAbstraction:
    """The layer of a level."""
    return SetAbstraction(
        inputs,
        level.count,
        level.radii,
        level.neighbours,
        level.channels,
        is_normalised=is_normalised,
    )
