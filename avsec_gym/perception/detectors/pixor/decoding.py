"""From PIXOR's output to rectangles on the ground: the best cells, one for each object."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.pixor.cell_coding import decode
from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration
from avsec_gym.perception.detectors.pixor.network import PixorOutput
from avsec_gym.perception.nn.rotated_nms import rotated_nms


@dataclass(frozen=True)
class PixorDecodingRule:
    """Which cells become objects; the defaults are those of the public code."""

    least_score: float = 0.05
    candidates: int = 64
    """Cells of a scan, best first, that enter the suppression."""
    most_overlap: float = 0.1
    """Intersection over union of two rectangles that may both stay."""

    def __post_init__(self) -> None:
        if not (0 < self.least_score < 1 and 0 <= self.most_overlap <= 1 and self.candidates > 0):
            raise ConfigurationError(
                f"scores and overlaps are shares, candidates 1 or more, got {self}"
            )


def found_rectangles(
    output: PixorOutput,
    configuration: PixorConfiguration,
    rule: PixorDecodingRule = PixorDecodingRule(),
) -> list[tuple[Floats, Floats]]:
    """The objects of each scan, best score first.

    Args:
        output: The output of the network, B scans.
        configuration: The configuration of the network.
        rule: What becomes an object.

    Returns:
        B pairs: rectangles ``x, y, length, width, heading`` in the velodyne frame, shape (N, 5),
        and scores, shape (N,).
    """
    corners = configuration.corners()
    found = []
    for scores, values in zip(output.scores, output.values, strict=True):
        cells = (scores > rule.least_score).nonzero()
        best = torch.argsort(scores[tuple(cells.T)], descending=True, stable=True)
        row, column = cells[best[: rule.candidates]].T
        sure = scores[row, column].double().cpu().numpy()
        numbers = values[:, row, column].T.double().cpu().numpy()
        places = corners[row.cpu().numpy(), column.cpu().numpy()]
        rectangles = decode(numbers, places, configuration)
        stays = rotated_nms(rectangles, sure, rule.most_overlap)
        found.append((rectangles[stays], sure[stays]))
    return found
