"""What DSGN searches: planes of depth, voxels of the world, and the boxes that stand in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats


@dataclass(frozen=True)
class DepthScale:
    """Depths in metres, from far to near, their steps equal in ``depth ** power``.

    A power of 1 spaces them equally in metres, -1 in disparity, and 0, between the two, in the
    logarithm.
    """

    far: float
    near: float
    count: int
    power: int = 1

    def __post_init__(self) -> None:
        if not self.far > self.near > 0 or self.count < 2:
            raise ConfigurationError(f"a depth scale falls from far to near > 0, got {self}")

    def values(self) -> Floats:
        """The depths, shape (count,)."""
        steps = np.linspace(self._warped(self.far), self._warped(self.near), self.count)
        return np.exp(steps) if self.power == 0 else steps ** (1 / self.power)

    def position(self, depth: Floats) -> Floats:
        """How far along the scale depths lie: -1 at the far end, 1 at the near one."""
        start, stop = self._warped(self.far), self._warped(self.near)
        return 2 * (self._warped(depth) - start) / (stop - start) - 1

    def _warped(self, depth: Floats | float) -> Floats:
        return np.asarray(np.log(depth) if self.power == 0 else np.power(depth, self.power))


@dataclass(frozen=True)
class GridAxis:
    """Cells of equal size between two coordinates (metres, camera frame); may run backwards."""

    start: float
    stop: float
    cells: int

    def centres(self) -> Floats:
        """Shape (cells,), metres, from start to stop."""
        return self.start + (np.arange(self.cells) + 0.5) * (self.stop - self.start) / self.cells


@dataclass(frozen=True)
class WorldGrid:
    """The voxels of the camera frame that are searched for objects; tensors are (z, y, x)."""

    x: GridAxis
    y: GridAxis
    z: GridAxis


@dataclass(frozen=True)
class Anchor:
    """The box that a class starts from, standing at every cell of the bird's-eye view (metres)."""

    category: str
    centre_y: float
    """The y of the box's centre, in the camera frame: y points down."""
    height: float
    width: float
    length: float


PEDESTRIAN = Anchor("Pedestrian", 0.74, 1.73, 0.6, 0.8)
CAR = Anchor("Car", 0.825, 1.56, 1.6, 3.9)
CYCLIST = Anchor("Cyclist", 0.74, 1.73, 0.6, 1.76)
