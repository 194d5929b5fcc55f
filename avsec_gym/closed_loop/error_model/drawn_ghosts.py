"""`DrawnGhosts`: the detections of nothing of a drive, which come, stay in the world, and go."""

from __future__ import annotations

import math

import numpy as np

from avsec_gym.closed_loop.error_model.model import Ghosts
from avsec_gym.closed_loop.relative_poses import Pose, in_world
from avsec_gym.geometry import Floats


class DrawnGhosts:
    """Draws the ghosts of a drive, instant after instant.

    Args:
        model: How many there are, where, and for how long.
    """

    def __init__(self, model: Ghosts) -> None:
        self.model = model
        self._places = np.array(model.seen, float).reshape(-1, 6)
        self.begin()

    def begin(self) -> None:
        """Forget the last drive's."""
        self._present: Floats | None = None

    def at(self, pose: Pose, passed: float, random: np.random.Generator) -> Floats:
        """The ghosts of this instant: some have gone, others have come, as many on average.

        Args:
            pose: The car's pose in the world, before which they come.
            passed: Seconds since the instant before.
            random: What they are drawn from.

        Returns:
            World x, y and heading, height, width, length, shape (G, 6).
        """
        if self._present is None:
            self._present, kept = np.zeros((0, 6)), 0.0
        else:
            kept = math.exp(-passed / self.model.seconds)
            self._present = self._present[random.random(len(self._present)) < kept]
        count = int(random.poisson(self.model.rate * (1 - kept)))
        if count:
            new = self._places[random.integers(len(self._places), size=count)]
            new[:, :3] = in_world(pose, new[:, :3])
            self._present = np.concatenate([self._present, new])
        return self._present
