"""`GivenBoxes`: stands for what the network regresses, where a test writes the corners down."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor

from avsec_gym.perception.detectors.dsgn.box_field import AnchorIndex


@dataclass(frozen=True, eq=False)
class GivenBoxes:
    """Corners of shape (B, A, K, 8, 3, Z, X) in the place of a `BoxField`."""

    corners: Tensor

    def everywhere(self) -> Tensor:
        return self.corners

    def at(self, index: AnchorIndex) -> Tensor:
        image, angle, kind, row, column = index
        return self.corners[image, angle, kind, :, :, row, column]
