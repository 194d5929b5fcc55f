"""How a box is coded beside a point or a proposal: in which bin its middle lies, and where in it.

The columns are those of github.com/sshaoshuai/PointRCNN: bins of x, bins of z, residuals of each
bin of x and of z, y, bins of the heading, residuals of each, and height, width and length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from avsec_gym.errors import ConfigurationError

MEAN_SIZE = (1.52563191462, 1.62856739989, 3.88311640418)
"""Height, width and length of KITTI's cars, metres."""
_ROUNDING = 1e-3
"""Metres or radians from the last bin's end that what is beyond it is moved to."""


@dataclass(frozen=True)
class BinCoding:
    """A code for boxes.

    Args:
        scope: How far to either side of it a middle may lie, in metres.
        bin: Side of a bin, metres.
        headings: Bins of the heading.
        is_fine: Whether headings are coded within a quarter turn about a proposal's own, and up to
            half a turn: the proposal states where the front is.
        size: The size of which sizes are coded as shares, more or less.

    Raises:
        ConfigurationError: Bins do not fill the scope.
    """

    scope: float = 3.0
    bin: float = 0.5
    headings: int = 12
    is_fine: bool = False
    size: tuple[float, float, float] = MEAN_SIZE

    def __post_init__(self) -> None:
        bins = 2 * self.scope / self.bin if self.bin > 0 else 0.0
        if round(bins) < 1 or abs(bins - round(bins)) > 1e-6 or self.headings < 1:
            raise ConfigurationError(
                f"2 x {self.scope} m are not made of bins of {self.bin} m, or there is none of"
                f" {self.headings} headings"
            )

    @property
    def bins(self) -> int:
        """The numbers of bins of x, and of z."""
        return round(2 * self.scope / self.bin)

    @property
    def channels(self) -> int:
        """Columns of the code."""
        return 4 * self.bins + 2 * self.headings + 4

    @property
    def heading_step(self) -> float:
        """Radians of a bin."""
        return (np.pi / 2 if self.is_fine else 2 * np.pi) / self.headings

    def parts(self, values: Tensor) -> CodeParts:
        """The columns (N, channels) of predicted codes."""
        bins, headings = self.bins, self.headings
        sizes = [bins, bins, bins, bins, 1, headings, headings, 3]
        return CodeParts(*torch.split(values, sizes, dim=1))

    def targets(self, boxes: Tensor) -> CodeTargets:
        """The numbers that a network should give for boxes.

        Args:
            boxes: x, y and z from the point or proposal, height, width, length, heading from the
                proposal's, shape (N, 7).
        """
        (x_bin, x), (z_bin, z) = (self._place(boxes[:, axis]) for axis in (0, 2))
        heading_bin, heading = self._heading(boxes[:, 6])
        mean = boxes.new_tensor(self.size)
        return CodeTargets(
            x_bin, z_bin, x, z, boxes[:, 1], heading_bin, heading, boxes[:, 3:6] / mean - 1
        )

    def decode(self, values: Tensor) -> Tensor:
        """The inverse: boxes (N, 7) from codes (N, channels), by their surest bins."""
        parts = self.parts(values)
        mean = values.new_tensor(self.size)
        places = []
        for bins, residuals in ((parts.x_bins, parts.x), (parts.z_bins, parts.z)):
            surest = bins.argmax(1, keepdim=True)
            place = (surest + 0.5) * self.bin - self.scope + residuals.gather(1, surest) * self.bin
            places.append(place)
        surest = parts.heading_bins.argmax(1, keepdim=True)
        steps = surest + 0.5 + parts.heading.gather(1, surest) / 2
        heading = self._first_heading + steps * self.heading_step
        if not self.is_fine:
            heading = (heading + np.pi) % (2 * np.pi) - np.pi
        size = (1 + parts.size) * mean
        return torch.cat([places[0], parts.y, places[1], size, heading], 1)

    @property
    def _first_heading(self) -> float:
        """Where the first bin begins: all around, its middle is 0."""
        return -np.pi / 4 if self.is_fine else -self.heading_step / 2

    def _place(self, offsets: Tensor) -> tuple[Tensor, Tensor]:
        shifted = (offsets + self.scope).clamp(0, 2 * self.scope - _ROUNDING)
        bins = (shifted / self.bin).floor()
        return bins.long(), shifted / self.bin - bins - 0.5

    def _heading(self, angles: Tensor) -> tuple[Tensor, Tensor]:
        """Bins, and where in them: from -1 to 1."""
        if self.is_fine:
            folded = (angles + np.pi / 2) % np.pi - np.pi / 4
            shifted = folded.clamp(_ROUNDING, np.pi / 2 - _ROUNDING)
        else:
            shifted = (angles - self._first_heading) % (2 * np.pi)
        # A remainder may be rounded up to a whole turn.
        bins = (shifted / self.heading_step).floor().clamp(max=self.headings - 1)
        return bins.long(), 2 * (shifted / self.heading_step - bins) - 1


@dataclass(frozen=True, eq=False)
class CodeParts:
    """Columns of N predicted codes.

    Args:
        x_bins: Logits, shape (N, bins).
        z_bins: The same of z.
        x: The distance along x from the middle of each bin, in bins, shape (N, bins).
        z: The same.
        y: The height y, metres, shape (N, 1).
        heading_bins: Logits, shape (N, headings).
        heading: The turn from the middle of each bin, in half bins, shape (N, headings).
        size: What the size is beyond the mean one, as its share, shape (N, 3).
    """

    x_bins: Tensor
    z_bins: Tensor
    x: Tensor
    z: Tensor
    y: Tensor
    heading_bins: Tensor
    heading: Tensor
    size: Tensor


@dataclass(frozen=True, eq=False)
class CodeTargets:
    """What they should be: bins as indices, and of residuals that of the right bin.

    Args:
        x_bin: The bin of x, shape (N,).
        z_bin: The bin of z, shape (N,).
        x: The place of x in its bin, shape (N,).
        z: The place of z in its bin, shape (N,).
        y: The height y, shape (N,).
        heading_bin: The bin of the heading, shape (N,).
        heading: The heading in its bin, shape (N,).
        size: The size, shape (N, 3).
    """

    x_bin: Tensor
    z_bin: Tensor
    x: Tensor
    z: Tensor
    y: Tensor
    heading_bin: Tensor
    heading: Tensor
    size: Tensor
