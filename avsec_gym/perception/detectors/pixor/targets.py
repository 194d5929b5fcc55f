"""The target of every cell: whether it is on an object, and where that one is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.pixor.cell_coding import encode
from avsec_gym.perception.detectors.pixor.configuration import PixorConfiguration


@dataclass(frozen=True, eq=False)
class PixorTargets:
    """Targets of B scans.

    Args:
        positive: Cells on an object, shape (B, rows, columns).
        judged: Cells of which the truth is known, the same shape.
        values: The values of positive cells, normalised, 0 elsewhere, shape (B, 6, rows, columns).
    """

    positive: Tensor
    judged: Tensor
    values: Tensor

    def to(self, device: torch.device | str) -> PixorTargets:
        """The targets on another device."""
        return PixorTargets(
            self.positive.to(device), self.judged.to(device), self.values.to(device)
        )

    @classmethod
    def concatenate(cls, parts: list[PixorTargets]) -> PixorTargets:
        """All scans in order."""
        return cls(
            torch.cat([part.positive for part in parts]),
            torch.cat([part.judged for part in parts]),
            torch.cat([part.values for part in parts]),
        )


def cell_targets(
    rectangles: Floats,
    configuration: PixorConfiguration,
    *,
    ignored: Floats | None = None,
    azimuths: tuple[float, float] = (-np.pi, np.pi),
) -> PixorTargets:
    """The targets of one scan.

    Args:
        rectangles: Objects, shape (N, 5), velodyne frame; every cell whose middle is on one is
            positive (of two on each other, for the second one).
        configuration: The configuration of the network.
        ignored: Rectangles whose cells are not judged, unless they are on an object.
        azimuths: The directions whose cells are judged, radians from x to the left: where
            labels are complete.
    """
    corners = configuration.corners()
    middles = corners + configuration.output_cell / 2
    owner = owners(middles, rectangles)
    positive = owner >= 0
    direction = np.arctan2(middles[..., 1], middles[..., 0])
    judged = (direction > azimuths[0]) & (direction < azimuths[1])
    if ignored is not None:
        judged &= positive | (owners(middles, ignored) < 0)
    values = np.zeros((*configuration.output_shape, 6), np.float32)
    values[positive] = encode(rectangles[owner[positive]], corners[positive], configuration)
    return PixorTargets(
        torch.from_numpy(positive)[None],
        torch.from_numpy(judged)[None],
        torch.from_numpy(values).permute(2, 0, 1)[None],
    )


def owners(places: Floats, rectangles: Floats) -> NDArray[np.int64]:
    """The last of the rectangles that each place is in, -1 where it is in none.

    Args:
        places: x and y, shape (..., 2).
        rectangles: The rectangles, shape (N, 5).

    Returns:
        Shape (...).
    """
    owner = np.full(places.shape[:-1], -1)
    for number, (x, y, length, width, heading) in enumerate(rectangles):
        east, north = places[..., 0] - x, places[..., 1] - y
        cos, sin = np.cos(heading), np.sin(heading)
        along, across = cos * east + sin * north, cos * north - sin * east
        owner[(np.abs(along) < length / 2) & (np.abs(across) < width / 2)] = number
    return owner
