"""Ghosts that last, and objects that stay hidden: an attack on what the car believes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.argument_checks import number_range, whole_number
from avsec_gym.attacks.object_injection import GhostRange, inject_ghosts
from avsec_gym.closed_loop.attack.drive_attack import DriveAttack, object_at
from avsec_gym.closed_loop.relative_poses import in_world, seen_from
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.pipeline import Perception

_OF_GHOST, _OF_HIDE = 4, 3
_SEEN_GHOST, _SEEN_HIDE = 5, 3
_FARTHEST = 50.0
"""Metres that 1 stands for in what the attacker observes."""
_BELONGS = 4.0
"""Metres within which a believed box is a detection of the nearest real object."""


class LastingGhosts(DriveAttack):
    """Ghosts on the road, and real objects taken away.

    Of each ghost an action has four numbers: above 0, it is up; where it is laid, ahead, left, and
    its heading.  A ghost that is up already stays at its place in the world; to move it, the
    attacker takes it down and lays it anew.  Of each hide an action has three numbers: above 0, an
    object is hidden, the one nearest to a place ahead and left; the same object stays hidden
    wherever it moves.  All is scaled linearly.  Each ghost and each hide takes an equal share of
    the energy of a frame.

    Args:
        ghosts: Ghosts at once, up to 16.
        hides: Objects hidden at once, up to 16.
        ahead: Metres ahead of the car, the first and the last, from 5 to 100.
        left: Metres to its left, the first and the last, within 20.

    Raises:
        ConfigurationError: A number is out of range, or there is neither a ghost nor a hide.
    """

    def __init__(
        self,
        ghosts: int = 1,
        hides: int = 1,
        ahead: tuple[float, float] = (5.0, 45.0),
        left: tuple[float, float] = (-8.0, 8.0),
    ) -> None:
        self.ghosts = whole_number("ghosts", ghosts, 0, 16)
        self.hides = whole_number("hides", hides, 0, 16)
        if not self.ghosts + self.hides:
            raise ConfigurationError("ghosts=0 and hides=0 leave nothing to attack with")
        self.range = GhostRange(
            x=number_range("ahead", ahead, 5.0, 100.0), y=number_range("left", left, -20.0, 20.0)
        )
        self.action_size = _OF_GHOST * self.ghosts + _OF_HIDE * self.hides
        self.state_size = _SEEN_GHOST * self.ghosts + _SEEN_HIDE * self.hides
        self.begin()

    def begin(self) -> None:
        """No ghost, and nothing hidden."""
        self._poses: list[Floats | None] = [None] * self.ghosts
        self._hidden: list[int | None] = [None] * self.hides

    def act(self, action: Floats, around: Surroundings) -> float:
        """Lay or take down ghosts, hide or show objects."""
        split = _OF_GHOST * self.ghosts
        on, poses = self.range.decode(action[:split].reshape(-1, _OF_GHOST))
        for row, (up, pose) in enumerate(zip(on, in_world(around.pose, poses), strict=True)):
            if not up:
                self._poses[row] = None
            elif self._poses[row] is None:
                self._poses[row] = pose
        # A place is that of a ghost without its heading.
        hides = action[split:].reshape(-1, _OF_HIDE)
        on, places = self.range.decode(np.column_stack([hides, np.zeros(len(hides))]))
        for row, (up, (ahead, left, _)) in enumerate(zip(on, places.tolist(), strict=True)):
            if not up:
                self._hidden[row] = None
            elif self._hidden[row] is None:
                self._hidden[row] = object_at(around, ahead, left)
        return (len(self._up) + len(self._chosen)) / (self.ghosts + self.hides)

    def state(self, around: Surroundings) -> Floats:
        """Each ghost in the car's frame: up, ahead and left / 50 m, cos and sin of the heading.

        Of each hide: up, ahead and left / 50 m of the hidden object; zeros where nothing is up.
        """
        ghosts = np.zeros((self.ghosts, _SEEN_GHOST))
        for row, pose in enumerate(self._poses):
            if pose is not None:
                [(x, y, heading)] = seen_from(around.pose, pose[None])
                place = x / _FARTHEST, y / _FARTHEST
                ghosts[row] = 1.0, *place, np.cos(heading), np.sin(heading)
        hides = np.zeros((self.hides, _SEEN_HIDE))
        for row, id in enumerate(self._hidden):
            there = around.actors == id
            if there.any():
                hides[row] = 1.0, *(around.boxes.poses[there][0, :2] / _FARTHEST)
        return np.concatenate([ghosts.ravel(), hides.ravel()])

    @property
    def facts(self) -> dict[str, float]:
        """`ghosts` that are up, and objects `hidden`."""
        return {"ghosts": len(self._up), "hidden": len(self._chosen)}

    def believed(self, perception: Perception, around: Surroundings) -> Perception:
        """The believed boxes without those of hidden objects, and with the ghosts."""
        boxes = perception.believed
        if self._chosen and len(boxes) and len(around.boxes):
            apart = boxes.poses[:, None, :2] - around.boxes.poses[None, :, :2]
            distance = np.hypot(apart[..., 0], apart[..., 1])
            nearest = distance.argmin(axis=1)
            hidden = np.isin(around.actors[nearest], self._chosen)
            boxes = boxes[~(hidden & (distance.min(axis=1) < _BELONGS))]
        if self._up:
            poses = seen_from(around.pose, np.array(self._up))
            boxes = inject_ghosts(boxes, poses, self.range.dimensions)
        return replace(perception, detections=boxes, believed=boxes)

    @property
    def _up(self) -> list[Floats]:
        return [pose for pose in self._poses if pose is not None]

    @property
    def _chosen(self) -> list[int]:
        return [id for id in self._hidden if id is not None]
