"""`DrawnErrors`: what a detector with these errors would have found, frame after frame."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.error_model.drawn_ghosts import DrawnGhosts
from avsec_gym.closed_loop.error_model.matching import LATERAL_REACH, radial_reach
from avsec_gym.closed_loop.error_model.model import COMPONENTS, ErrorModel
from avsec_gym.closed_loop.error_model.object_views import HALF_VIEW, object_views
from avsec_gym.closed_loop.relative_poses import Pose, seen_from
from avsec_gym.geometry import Floats, ego_to_camera

FOUND, TURNED = 0, 1
LATENT = 2 + len(COMPONENTS)
"""Standard normal numbers of each actor: whether it is found, whether it is turned round, and one
for each component."""


class DrawnErrors:
    """Draws the detections of a drive from an error model.

    Args:
        model: The errors.
        half_view: Half the horizontal angle of the camera, radians: nothing is found outside.
    """

    def __init__(self, model: ErrorModel, half_view: float = HALF_VIEW) -> None:
        self.model, self.half_view = model, half_view
        self._ghosts = DrawnGhosts(model.ghosts)
        self.begin(0)

    def begin(self, seed: int) -> None:
        """Forget the last drive; the next one's errors follow from the seed."""
        self._random = np.random.default_rng(seed)
        self._latent: dict[int, Floats] = {}
        self._ghosts.begin()
        self._time = 0.0

    def detect(
        self, boxes: Boxes3D, actors: NDArray[np.int64], pose: Pose, time: float
    ) -> tuple[Boxes3D, NDArray[np.int64]]:
        """What is found at an instant; called in the order of time.

        Args:
            boxes: All objects, in the camera frame, shape (N,).
            actors: Id of each object, the same over the drive, shape (N,).
            pose: The car's pose in the world, in which ghosts stay where they are.
            time: Seconds since the start of the drive.

        Returns:
            The detections, and the actor that each one is of; -1 for ghosts.
        """
        passed, self._time = time - self._time, time
        views = object_views(boxes, self.half_view)
        latent = self._remembered(actors, passed)
        # Gaussian copulas: each number is normal at every instant, and so is what it decides as
        # likely as the model wants it, however well it is remembered.
        found = ndtr(latent[:, FOUND]) < self.model.probabilities(boxes, views)
        seen = np.flatnonzero(found & (views.outside < 1))
        boxes, actors, latent = boxes[seen], actors[seen], latent[seen]
        real = self._displaced(boxes, views.distance[seen], views.bearing[seen], latent)
        drawn = self._ghosts.at(pose, passed, self._random)
        heights = np.full(len(drawn), _CAMERA_HEIGHT)
        ghosts = _cars(seen_from(pose, drawn[:, :3]), drawn[:, 3:], heights)
        return (
            Boxes3D.concatenate([real, ghosts]),
            np.concatenate([actors, np.full(len(ghosts), -1)]),
        )

    def _remembered(self, actors: NDArray[np.int64], passed: float) -> Floats:
        """The normal numbers of actors at this instant, shape (N, `LATENT`)."""
        kept = np.full(LATENT, math.exp(-passed / self.model.error_seconds))
        kept[FOUND] = math.exp(-passed / self.model.found_seconds)
        fresh = self._random.standard_normal((len(actors), LATENT))
        for row, actor in enumerate(actors.tolist()):
            if actor in self._latent:
                fresh[row] = kept * self._latent[actor] + np.sqrt(1 - kept**2) * fresh[row]
            self._latent[actor] = fresh[row]
        return fresh

    def _displaced(
        self, boxes: Boxes3D, distance: Floats, bearing: Floats, latent: Floats
    ) -> Boxes3D:
        shares = ndtr(latent)
        error = {
            name: self.model.spreads[name].quantiles(shares[:, 2 + column], distance)
            for column, name in enumerate(COMPONENTS)
        }
        # What is farther off is matched with nothing: it was fitted as a miss and a ghost.
        reach = radial_reach(distance)
        error["radial"] = np.clip(error["radial"], -reach, reach)
        error["lateral"] = np.clip(error["lateral"], -LATERAL_REACH, LATERAL_REACH)
        poses = boxes.poses
        cos, sin = np.cos(bearing), np.sin(bearing)
        poses[:, 0] += cos * error["radial"] - sin * error["lateral"]
        poses[:, 1] += sin * error["radial"] + cos * error["lateral"]
        poses[:, 2] += error["turn"] + np.pi * (shares[:, TURNED] < self.model.turned_round)
        dimensions = boxes.dimensions.copy()
        # Tails are heavy, cars are not: a third to three times the size.
        dimensions[:, 1] *= np.exp(np.clip(error["log_width"], -1, 1))
        dimensions[:, 2] *= np.exp(np.clip(error["log_length"], -1, 1))
        return _cars(poses, dimensions, boxes.location[:, 1])


_CAMERA_HEIGHT = 1.65
"""Metres of the camera above the ground on which ghosts stand."""


def _cars(poses: Floats, dimensions: Floats, height: Floats) -> Boxes3D:
    """Detected cars at ego poses."""
    location, rotation_y = ego_to_camera(poses, height)
    count = len(poses)
    return Boxes3D(location, dimensions, rotation_y, np.ones(count), np.full(count, "Car"))
