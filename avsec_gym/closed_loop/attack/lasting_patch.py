"""A patch that lasts: a poster on a vehicle or at the roadside, larger as one approaches."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.argument_checks import number, number_range
from avsec_gym.attacks.attack import LEFT, RIGHT, quantised
from avsec_gym.attacks.patch_files import Patch, patch_of
from avsec_gym.attacks.patch_pasting import paste_on_frame
from avsec_gym.attacks.patch_placement import (
    PatchPlace,
    PatchRange,
    focal_times_baseline,
    nearest_behind,
)
from avsec_gym.closed_loop.attack.drive_attack import DriveAttack, object_at
from avsec_gym.closed_loop.relative_poses import in_world, seen_from
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import Floats, ego_to_camera, project

_FARTHEST = 50.0
_LEAST_DEPTH = 1.0
"""Metres in front of the camera below which the poster is passed and fills no image any more."""


@dataclass(frozen=True, eq=False)
class _Poster:
    """Where the poster is now.

    Args:
        centre: Its centre in the camera frame, metres, shape (3,).
        diameter: Its diameter, metres.
        ahead: Metres ahead of the car.
        left: Metres to its left.
    """

    centre: Floats
    diameter: float
    ahead: float
    left: float


class LastingPatch(DriveAttack):
    """A round poster that faces the car, with the pattern of a patch.

    An action has five numbers: above 0, the poster is up; above 0, a vehicle carries it on the side
    that it shows to the car, the vehicle nearest to a place ahead and left, else it stands at that
    place; its diameter.  A poster that is up already stays on its vehicle or at its place in the
    world, and as large as it was laid; to move it, the attacker takes it down and lays it anew.
    All is scaled linearly.  The energy of a frame is the poster's area, as a share of the largest.

    Both cameras see it where the calibration puts it, by `avsec_gym.attacks.patch_pasting`: its
    radius in the image is f D / 2 Z, its disparity f b / Z at the depth Z.  On a vehicle it is no
    larger than that is wide and high.  It is left out of frames in which a real object nearer than
    it covers a part of it.  The LiDAR does not see it.

    Args:
        patch: A patch, its file, or a name, see `patch_of`; None: the package's own against both
            stereo detectors, ``joint``.
        ahead: Metres ahead of the car, the first and the last, from 5 to 100.
        left: Metres to its left, the first and the last, within 20.
        diameters: The smallest and the largest diameter, metres, from 0.05 to 10.
        height: Metres of its centre above the road where it stands by itself, from 0 to 10.

    Raises:
        ConfigurationError: A number is out of range, or it is no patch.
        DataError: The patch's file is missing or damaged.
    """

    action_size, state_size, sensors = 5, 5, frozenset({LEFT, RIGHT})

    def __init__(
        self,
        patch: Patch | str | Path | None = None,
        ahead: tuple[float, float] = (8.0, 40.0),
        left: tuple[float, float] = (-8.0, 8.0),
        diameters: tuple[float, float] = (0.5, 2.0),
        height: float = 1.2,
    ) -> None:
        spans = (
            number_range("ahead", ahead, 5.0, 100.0),
            number_range("left", left, -20.0, 20.0),
            number_range("diameters", diameters, 0.05, 10.0),
        )
        self._low, self._high = np.array(spans).T
        self._height = number("height", height, 0.0, 10.0)
        self.patch = patch_of("joint" if patch is None else patch)
        self.begin()

    def begin(self) -> None:
        """No poster."""
        self._carrier: int | None = None
        self._place: Floats | None = None
        self._diameter = 0.0

    def act(self, action: Floats, around: Surroundings) -> float:
        """Put the poster up, keep it up, or take it down."""
        if action[0] <= 0:
            self.begin()
            return 0.0
        if self._carrier is None and self._place is None:
            scaled = self._low + 0.5 * (action[2:] + 1.0) * (self._high - self._low)
            ahead, left, diameter = scaled.tolist()
            if action[1] > 0:
                self._carrier = object_at(around, ahead, left)
            else:
                [self._place] = in_world(around.pose, np.array([[ahead, left, 0.0]]))
            self._diameter = diameter if self._is_up else 0.0
        return float((self._diameter / self._high[2]) ** 2)

    @property
    def _is_up(self) -> bool:
        return self._carrier is not None or self._place is not None

    def state(self, around: Surroundings) -> Floats:
        """Up; carried by a vehicle; ahead and left / 50 m; diameter / largest.

        Zeros where it is down, and for place and diameter where its vehicle is gone.
        """
        if not self._is_up:
            return np.zeros(self.state_size)
        poster, carried = self._poster(around), float(self._carrier is not None)
        if poster is None:
            return np.array([1.0, carried, 0.0, 0.0, 0.0])
        place = poster.ahead / _FARTHEST, poster.left / _FARTHEST
        return np.array([1.0, carried, *place, poster.diameter / self._high[2]])

    @property
    def facts(self) -> dict[str, float]:
        """The `diameter`, metres, 0 for none, and whether a vehicle has `carried` it."""
        return {"diameter": self._diameter, "carried": float(self._carrier is not None)}

    def tampered(self, frame: SensorFrame, around: Surroundings) -> SensorFrame:
        """The frame with the poster in both views, where the cameras see it."""
        place = self.place(frame.calibration, around)
        if place is None:
            return frame
        # Whole grey levels, as a camera delivers them: validators read no others.
        return quantised(paste_on_frame(frame, self.patch.pixels, place, may_stick_out=True))

    def place(self, calibration: Calibration, around: Surroundings) -> PatchPlace | None:
        """Where the left image shows the poster; None: nowhere.

        Args:
            calibration: Calibration of the cameras.
            around: The truth around the car.
        """
        poster = self._poster(around)
        if poster is None:
            return None
        pixel, depth = project(calibration.projection(LEFT), poster.centre)
        if depth < _LEAST_DEPTH:
            return None
        u, v = pixel.tolist()
        radius = 0.5 * poster.diameter * calibration.focal_length(LEFT) / float(depth)
        others = around.boxes[around.actors != self._carrier]
        if nearest_behind(calibration, others, u, v, radius) < depth:
            return None
        disparity = focal_times_baseline(calibration) / float(depth)
        return PatchPlace(u, v, disparity, radius=radius)

    def _poster(self, around: Surroundings) -> _Poster | None:
        """The poster as it is now; None: it is down, or its vehicle is gone."""
        if self._place is not None:
            foot = seen_from(around.pose, self._place[None])
            [centre], _ = ego_to_camera(foot, PatchRange.camera_height - self._height)
            return _Poster(centre, self._diameter, float(foot[0, 0]), float(foot[0, 1]))
        there = around.actors == self._carrier
        if self._carrier is None or not there.any():
            return None
        box = around.boxes[there]
        high, wide, long = box.dimensions[0].tolist()
        x, y, heading = box.poses[0].tolist()
        # The end of the vehicle that it shows to the car: its rear, or an oncoming one's front.
        forward = np.array([np.cos(heading), np.sin(heading)])
        away = 1.0 if forward @ (x, y) > 0 else -1.0
        ahead, left = ((x, y) - away * 0.5 * long * forward).tolist()
        bottom = float(box.location[0, 1])
        centre, _ = ego_to_camera((ahead, left, 0.0), bottom - 0.5 * high)
        return _Poster(centre, min(self._diameter, wide, high), ahead, left)
