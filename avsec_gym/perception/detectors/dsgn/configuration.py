"""What a DSGN is made of: every number and switch of the architecture, and its presets."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.dsgn.decoding_rule import DsgnDecodingRule
from avsec_gym.perception.detectors.dsgn.grid import (
    CAR,
    CYCLIST,
    PEDESTRIAN,
    Anchor,
    DepthScale,
    GridAxis,
    WorldGrid,
)
from avsec_gym.perception.nn.pyramid_pooling import FeatureConfiguration
from avsec_gym.perception.presets import preset_named

_FEATURES = FeatureConfiguration(
    first=64,
    stages=((32, 3), (64, 6), (128, 12), (192, 4)),
    joined=(2, 3, 4),
    aligned_corners=True,
    matching=(256, 32),
    semantic=(64, 32),
    groups=32,
)
_PLANES = DepthScale(40.0, 2.4, 48)
_BINS = DepthScale(40.2, 2.0, 192)
_SAMPLED = DepthScale(40.4, 2.0, 2)
_GRID = WorldGrid(GridAxis(-30.4, 30.4, 304), GridAxis(3.0, -1.0, 20), GridAxis(40.4, 2.0, 192))


@dataclass(frozen=True)
class DsgnConfiguration:
    """The architecture; the defaults are those of the original car detector.

    Raises:
        ConfigurationError: Numbers that do not fit together, or an unknown preset.
    """

    input_size: tuple[int, int] | None = None
    """Height and width that images are scaled to; None leaves them as they are."""
    padded_size: tuple[int, int] = (384, 1248)
    """Zeros are added at the right and below up to this size; multiples of 16."""
    features: FeatureConfiguration = _FEATURES
    """Features of the images. The semantic head also decides whether its features enter the world
    grid."""
    groups: int = 32
    """Groups of normalised channels behind the features, see `normalisation`."""

    planes: DepthScale = _PLANES
    """Planes of the plane-sweep volume."""
    bins: DepthScale = _BINS
    """Bins of the softmax over depth: the planes' costs are interpolated."""
    sampled: DepthScale = _SAMPLED
    """Which depths lie at the centres of the first and last plane (or bin) where the world grid
    samples the volume; the original takes the grid's ends, 0.4 m off."""
    full_depth: bool = True
    """Costs enlarged to the image before the softmax; otherwise the expected depth is."""
    correlation_groups: int = 0
    """Correlation groups of matching features whose products fill the volume; 0 fills it with both
    features."""
    volume_channels: int = 64
    volume_begins_with_hourglass: bool = False
    """One hourglass in the place of four convolutions and an hourglass on a residual."""
    volume_residual: bool = False
    """Whether what comes into that one hourglass is added to what it makes."""
    cost_kernel: int = 3
    """The kernel of the two convolutions that make a cost of each plane."""

    grid: WorldGrid = _GRID
    aligned_corners: bool = True
    """The rule of every sampling by the world grid: -1 and 1 are the centres of the outermost cells
    (torch below 1.3, with which the published weights were trained) or their outer edges."""
    exact_pixels: bool = False
    """Feature i stands at pixel 4 i, where its convolutions centre it; otherwise the features are
    stretched so that the last one stands at the last pixel, up to 3 pixels off."""
    costs_in_grid: bool = True
    """Whether the planes' costs, without gradient, enter the world grid."""
    grid_channels: int = 64
    grid_kernel: int = 3
    grid_hourglass: bool = True
    pooled_heights: int = 4
    """Layers of the grid that one mean over y takes in."""
    view_channels: int = 128
    """Channels of the bird's-eye view."""

    tower_length: int = 1
    """Convolutions in each of the two halves of a tower."""
    anchors: tuple[Anchor, ...] = (PEDESTRIAN, CAR, CYCLIST)
    angles: int = 4
    """Anchors of each class, evenly turned."""
    half_turns: bool = False
    """Whether an anchor stands for a box and for the same box turned round: the angles then spread
    over half a turn, and a number of each anchor states which way its box heads."""
    fit: bool = False
    """Whether a number of each anchor estimates how well its box fits: the intersection over
    union in space with the object."""

    depth_loss: Literal["expectation", "planes"] = "expectation"
    """The loss of depth: the smooth L1 error of the expectation, or the cross entropy of the bins
    against the two beside the true depth."""
    object_pixels: float = 1.0
    """The weight in the cross entropy of a pixel on an object that is learned; all others have
    1."""

    rule: DsgnDecodingRule = field(default_factory=DsgnDecodingRule)
    """Which anchors become boxes."""

    def __post_init__(self) -> None:
        if self.grid.y.cells % self.pooled_heights:
            raise ConfigurationError(
                f"{self.grid.y.cells} layers of the grid are not a multiple of the"
                f" {self.pooled_heights} that are pooled"
            )
        pair = self.correlation_groups or 2 * self.features.matching[1]
        if self.volume_begins_with_hourglass and pair != self.volume_channels:
            raise ConfigurationError(
                f"an hourglass keeps its channels, yet {pair} come in and"
                f" volume_channels is {self.volume_channels}"
            )
        if self.correlation_groups and self.features.matching[1] % self.correlation_groups:
            raise ConfigurationError(
                f"{self.features.matching[1]} features do not make {self.correlation_groups} groups"
            )
        if self.object_pixels <= 0 or (self.rule.fit_share > 0 and not self.fit):
            raise ConfigurationError(
                "pixels have positive weights, and a score has a share of the fit only where it is"
                f" predicted, got {self.object_pixels} and {self.rule.fit_share}"
            )
        sizes = {
            "padded_size": (*self.padded_size, 16),
            "planes": (self.planes.count, 4),
            "the grid's cells along x and z": (self.grid.x.cells, self.grid.z.cells, 4),
        }
        if self.grid_hourglass:
            sizes["the grid's cells along y"] = (self.grid.y.cells, 4)
        for name, (*counts, divisor) in sizes.items():
            if any(count <= 0 or count % divisor for count in counts):
                raise ConfigurationError(f"{name}: {counts} must be multiples of {divisor}")
        if self.input_size is not None and (
            self.input_size[0] > self.padded_size[0] or self.input_size[1] > self.padded_size[1]
        ):
            raise ConfigurationError(
                f"images of {self.input_size} do not fit into {self.padded_size}"
            )

    def anchor_angles(self) -> Floats:
        """Yaw of each anchor, radians, shape (angles,)."""
        whole = np.pi if self.half_turns else 2 * np.pi
        return whole / self.angles * np.arange(self.angles, dtype=np.float64)

    @classmethod
    def preset(cls, name: str) -> DsgnConfiguration:
        """``default``, ``24g`` and ``12g`` (the original's for cars), ``small`` or ``medium``.

        And ``small_without_pyramid``: without the means over windows, for an ablation.
        """
        return preset_named("DSGN", name, _PRESETS)


def without_pyramid(configuration: DsgnConfiguration) -> DsgnConfiguration:
    """The same weights without the means over windows, for an ablation."""
    return replace(configuration, features=replace(configuration.features, pyramid=False))


_DEFAULT = DsgnConfiguration()
_24G = replace(
    _DEFAULT,
    features=replace(_FEATURES, first=16, semantic=None),
    volume_begins_with_hourglass=True,
    costs_in_grid=False,
    grid_kernel=1,
    grid_hourglass=False,
)
_12G = replace(
    _24G,
    features=replace(
        _24G.features,
        first=8,
        stages=((16, 3), (32, 4), (64, 6), (128, 3)),
        matching=(128, 32),
    ),
)
FIRST_SMALL = DsgnConfiguration(
    # Disparity, and with it depth, lies in the columns, not in the rows.
    input_size=(128, 768),
    padded_size=(128, 768),
    features=FeatureConfiguration(
        first=16,
        stages=((16, 1), (32, 2), (48, 1), (48, 1)),
        joined=(2, 3, 4),
        windows=((32, 48), (16, 24), (8, 12), (4, 6)),
        pooled=8,
        aligned_corners=True,
        matching=(32, 32),
        semantic=(32, 16),
        groups=4,
    ),
    groups=4,
    # In the logarithm: 0.3 m apart at 4 m, 1.4 m at 20 m; 0.1 to 1.3 pixels of the features.
    planes=DepthScale(48.0, 3.2, 40, power=0),
    bins=DepthScale(48.0, 3.2, 40, power=0),
    sampled=DepthScale(48.0, 3.2, 2, power=0),
    full_depth=False,
    # Learns to match sooner than joined features: in a trial of one seed, the depth loss after
    # 160 pairs was 1.7 against 4.5.
    correlation_groups=8,
    volume_channels=8,
    volume_begins_with_hourglass=True,
    volume_residual=True,
    cost_kernel=1,
    grid=WorldGrid(GridAxis(-20.0, 20.0, 100), GridAxis(3.0, -1.0, 5), GridAxis(48.0, 3.2, 112)),
    exact_pixels=True,
    grid_channels=16,
    grid_kernel=1,
    grid_hourglass=False,
    pooled_heights=1,
    view_channels=48,
    anchors=(CAR,),
    # By average precision on the validation suite: 0.6 leaves doubles, below 0.3 little changes.
    rule=DsgnDecodingRule(most_overlap=0.2),
)
"""The small one of the first edition, 2026, for the weights that were trained for it."""

_SMALL = replace(
    FIRST_SMALL,
    # 5.9 % apart, where the first edition's were 7 %.
    planes=DepthScale(48.0, 3.2, 48, power=0),
    bins=DepthScale(48.0, 3.2, 48, power=0),
    correlation_groups=16,
    volume_channels=16,
    grid=WorldGrid(GridAxis(-20.0, 20.0, 100), GridAxis(3.0, -1.0, 10), GridAxis(48.0, 3.2, 112)),
    # 32 channels enter the grid's convolution; with the costs, one more, it would take half as long
    # again.
    costs_in_grid=False,
    grid_kernel=3,
    angles=2,
    half_turns=True,
    fit=True,
    depth_loss="planes",
    object_pixels=8.0,
    # By average precision on 100 validation frames; the study `decoding_rules` undoes each.
    rule=DsgnDecodingRule(most_overlap=0.3, voting_overlap=0.7, fit_share=0.5),
)
_MEDIUM = replace(
    _SMALL,
    input_size=(192, 1152),
    padded_size=(192, 1152),
    features=replace(_SMALL.features, windows=((48, 72), (24, 36), (12, 18), (6, 9))),
    planes=DepthScale(48.0, 3.2, 64, power=0),
    bins=DepthScale(48.0, 3.2, 64, power=0),
    # Cells of 0.28 m; every weight of the small one fits.
    grid=WorldGrid(GridAxis(-19.6, 19.6, 140), GridAxis(3.0, -1.0, 10), GridAxis(48.0, 3.2, 160)),
)
_PRESETS = {
    "default": _DEFAULT,
    "24g": _24G,
    "12g": _12G,
    "small": _SMALL,
    "small_without_pyramid": without_pyramid(_SMALL),
    "medium": _MEDIUM,
}
"""The original's for cars; for two threads of a CPU, 0.3 s and 1.5 s a frame; and an ablation."""
