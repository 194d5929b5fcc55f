"""The boxes that DSGN regresses at its anchors, made corners only where a loss asks for them.

All corners of a bird's-eye view are 24 numbers for each of ten thousands of anchors, of which a
loss takes a few hundred.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration

AnchorIndex = tuple[Tensor, Tensor, Tensor, Tensor, Tensor]
"""Image, angle, class, row and column of P anchors, int64, each of shape (P,)."""


@dataclass(frozen=True, eq=False)
class BoxField:
    """Boxes at every anchor of B pairs.

    Args:
        regressed: Place (3), logarithm of size over the anchor's (height, width, length), and a
            turn for each of A angles, shape (B, K, 6 + A, Z, X).
        configuration: Anchors and angles.
    """

    regressed: Tensor
    configuration: DsgnConfiguration

    def everywhere(self) -> Tensor:
        """The corners of all anchors, as of `DsgnOutput.corners`, shape (B, A, K, 8, 3, Z, X)."""
        # (B, K, Z, X, 6 + A), and angles before all else but the image
        values = self.regressed.permute(0, 1, 3, 4, 2)
        offset, size, turn = values[..., :3], values[..., 3:6], values[..., 6:]
        yaw = self._angles(turn) + turn.tanh() * self._reach()
        corners = _corners(
            offset[..., None, :],
            (self._anchor_sizes(size)[:, None, None] * size.exp())[..., None, :],
            yaw,
        )  # (B, K, Z, X, A, 8, 3)
        return corners.permute(0, 4, 1, 5, 6, 2, 3)

    def at(self, index: AnchorIndex) -> Tensor:
        """The corners of some anchors, shape (P, 8, 3); single precision where halves come in."""
        image, angle, kind, row, column = index
        values = self.regressed[image, kind, :, row, column]
        values = values.to(torch.promote_types(values.dtype, torch.float32))
        turn = values[:, 6:].gather(1, angle[:, None])[:, 0]
        yaw = self._angles(values)[angle] + turn.tanh() * self._reach()
        return _corners(values[:, :3], self._anchor_sizes(values)[kind] * values[:, 3:6].exp(), yaw)

    def _anchor_sizes(self, like: Tensor) -> Tensor:
        """Height, width and length of each class, shape (K, 3)."""
        anchors = self.configuration.anchors
        return like.new_tensor([[a.height, a.width, a.length] for a in anchors])

    def _angles(self, like: Tensor) -> Tensor:
        return torch.from_numpy(self.configuration.anchor_angles()).to(like)

    def _reach(self) -> float:
        """Radians by which a box is turned from its anchor at most: halfway to the next one."""
        return (math.pi if self.configuration.half_turns else 2 * math.pi) / (
            2 * self.configuration.angles
        )


def _corners(offset: Tensor, size: Tensor, yaw: Tensor) -> Tensor:
    """Corners (..., 8, 3) of boxes: offset (..., 3), size (..., 3), yaw (...), broadcast."""
    height, width, length = size.unbind(-1)
    cos, sin = yaw.cos(), yaw.sin()
    corners = []
    for up in (0.5, -0.5):  # y points down: the bottom face first
        for along, across in ((0.5, 0.5), (0.5, -0.5), (-0.5, -0.5), (-0.5, 0.5)):
            forward, aside = along * length, across * width
            x, z = forward * cos + aside * sin, aside * cos - forward * sin
            corners.append(torch.stack([x, (up * height).expand_as(x), z], -1))
    return torch.stack(corners, -2) + offset[..., None, :]
