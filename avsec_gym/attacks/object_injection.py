"""Attacks on the detections themselves: ghost objects put in, real objects hidden.

The strongest thing that an attack on perception can bring about, without the perception: boxes
appear where nothing is (as under the thesis' patch and perturbation attacks, figures 5.2 and 5.5)
or real ones are missed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import instance_of, number_range, numbers, whole_number
from avsec_gym.attacks.argument_domains import ANGLES, MOST_GHOSTS, PLACES, STEPS, WIDTHS
from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, ego_to_camera

_CAMERA_HEIGHT = 1.65


@dataclass(frozen=True)
class GhostRange:
    """What ghosts an attacker can make; its actions in [-1, 1] scale linearly to the ranges.

    Ghosts begin far enough ahead that they never overlap the ego vehicle at the start.
    """

    x: tuple[float, float]
    """Metres ahead."""
    y: tuple[float, float] = (-8.0, 8.0)
    """Metres to the left."""
    heading: tuple[float, float] = (-np.pi, np.pi)
    dimensions: tuple[float, float, float] = (1.53, 1.63, 3.88)
    """Height, width, length of a ghost, m; by default KITTI's mean car."""

    def __post_init__(self) -> None:
        for name, limits in (("x", PLACES), ("y", PLACES), ("heading", ANGLES)):
            object.__setattr__(self, name, number_range(name, getattr(self, name), *limits))
        dimensions = numbers("dimensions", self.dimensions, 3, *WIDTHS)
        object.__setattr__(self, "dimensions", dimensions)

    def decode(self, actions: Floats) -> tuple[NDArray[np.bool_], Floats]:
        """Actions to ghosts.

        Args:
            actions: Actions on/off, x, y, heading of each ghost, in [-1, 1], shape (..., 4).

        Returns:
            Which are on (above 0), shape (...), and poses in the ego frame, shape (..., 3).
        """
        actions = np.maximum(np.minimum(np.asarray(actions, float), 1.0), -1.0)
        low, size = self._low_and_size
        return actions[..., 0] > 0, low + 0.5 * (actions[..., 1:] + 1.0) * size

    def encode(self, on: NDArray[np.bool_], poses: Floats) -> Floats:
        """The inverse of `decode`, shape (..., 4)."""
        low, size = self._low_and_size
        scaled = 2.0 * (np.asarray(poses, float) - low) / size - 1.0
        return np.concatenate([np.where(on, 1.0, -1.0)[..., None], scaled], axis=-1)

    @cached_property
    def _low_and_size(self) -> tuple[Floats, Floats]:
        """The lower ends of x, y, heading, and how far it is to the upper ones, shape (3,) each."""
        low, high = np.array([self.x, self.y, self.heading]).T
        return low, high - low


GHOSTS = {
    "patch": GhostRange(x=(10.0, 30.0), dimensions=(1.5, 1.0, 1.0)),
    "car": GhostRange(x=(5.0, 30.0)),
}
"""``patch``: as wide as the thesis' patch of 38 pixels radius looks 10 m ahead, and no nearer.
``car``: whole cars, as near as 5 m; one of them right ahead blocks every way."""


def inject_ghosts(
    boxes: Boxes3D,
    poses: Floats,
    dimensions: tuple[float, float, float] = GHOSTS["car"].dimensions,
    score: float = 1.0,
) -> Boxes3D:
    """Detections with ghosts, taken for cars, added at the end.

    Args:
        boxes: Detections without the attack.
        poses: Ego-frame x, y (m), heading (rad), shape (G, 3).
        dimensions: Height, width, length of the ghosts, m.
        score: The confidence that the ghosts are detected with.
    """
    poses = np.asarray(poses, float).reshape(-1, 3)
    location, rotation_y = ego_to_camera(poses, _CAMERA_HEIGHT)
    count = len(poses)
    ghosts = Boxes3D(
        location=location,
        dimensions=np.tile(dimensions, (count, 1)),
        rotation_y=rotation_y,
        score=np.full(count, score),
        category=np.full(count, "Car"),
        moving=np.zeros(count, bool),
    )
    return Boxes3D.concatenate([boxes, ghosts])


def hide_objects(boxes: Boxes3D, hidden: NDArray[np.intp]) -> Boxes3D:
    """Detections without some of them.

    Args:
        boxes: Detections without the attack.
        hidden: Rows to drop; rows beyond the end are ignored.
    """
    keep = np.ones(len(boxes), bool)
    keep[[row for row in np.unique(hidden) if 0 <= row < len(boxes)]] = False
    return boxes[keep]


@dataclass(frozen=True)
class RandomGhosts:
    """The baseline attacker: ghosts at random places until the episode is unsafe.

    Args:
        ghosts: Number of ghosts at once.
        queries: Number of attempts.
        range: Range of the ghosts' places and sizes.

    Raises:
        ConfigurationError: No such number, or something else than a range.
    """

    ghosts: int = 2
    queries: int = 10
    range: GhostRange = GHOSTS["car"]

    def __post_init__(self) -> None:
        object.__setattr__(self, "ghosts", whole_number("ghosts", self.ghosts, 0, MOST_GHOSTS))
        object.__setattr__(self, "queries", whole_number("queries", self.queries, 1, STEPS))
        instance_of("range", self.range, GhostRange)

    def attack(
        self, boxes: Boxes3D, is_unsafe: Callable[[Boxes3D], bool], seed: int | Sequence[int]
    ) -> tuple[Boxes3D, int]:
        """Try random places.

        Args:
            boxes: Detections without the attack.
            is_unsafe: Queries the victim: whether the episode on these detections is unsafe.
            seed: Seed of the places.

        Returns:
            The last attacked detections, and the number of queries spent.
        """
        generator = np.random.default_rng(seed)
        attacked = boxes
        for query in range(1, self.queries + 1):
            actions = generator.uniform(-1.0, 1.0, (self.ghosts, 4))
            actions[:, 0] = 1.0
            _, poses = self.range.decode(actions)
            attacked = inject_ghosts(boxes, poses, self.range.dimensions)
            if is_unsafe(attacked):
                return attacked, query
        return attacked, self.queries
