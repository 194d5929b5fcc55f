"""Detectors that know the truth, as far as an optical attack lets it through.

With them the worth of a defence is measured apart from that of a network: they see everything that
is labelled, but nothing behind a facula, and whatever bogus returns show.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Image, Points, SensorFrame
from avsec_gym.geometry import Floats, box_corners, project, transform_points

STEREO_ORACLE, LIDAR_ORACLE = "oracle", "lidar_oracle"
BLINDING = 64
"""Grey levels; light that adds more hides what is behind it: things differ by less."""
_HIDDEN = 0.5
"""Share of an object's area in the image; of which more is hidden, it is not seen."""
_FEWEST_POINTS = 50
"""Fewest points of an obstacle in a scan."""
_LOWEST = 0.3
"""Metres; what stands up less is driven over.  Where a bogus return meets the road it agrees
with the road, and no repair removes it."""
_THINNEST = 0.1
"""Metres; a bogus return is as thin as a screen."""


@dataclass(eq=False)
class StereoOracle:
    """Sees every object that is hidden in neither image of the pair, by half or more.

    Hidden is what differs from the clean image by more than `BLINDING`.  Any two cameras of the rig
    may stand under the pair's numbers: it knows them by their projections.

    Args:
        clean: The frame before the attack.
        truth: The boxes of what is there.
    """

    clean: SensorFrame
    truth: Boxes3D
    name: str = STEREO_ORACLE

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """See `Detector`."""
        seen = np.ones(len(self.truth), bool)
        for camera in (LEFT, RIGHT):
            projection = frame.calibration.projection(camera)
            own = next(
                camera
                for camera in self.clean.calibration.cameras
                if np.array_equal(self.clean.calibration.projection(camera), projection)
            )
            hidden = _hidden_pixels(frame.image(camera), self.clean.image(own))
            seen &= _shares(hidden, self.truth, projection) <= _HIDDEN
        return self.truth[seen]


@dataclass(eq=False)
class LidarOracle:
    """Sees every object, and an obstacle where bogus points stand up from the lowest of them.

    Args:
        bogus: The returns that an attacker sent, shape (B, 4); those that are left in a scan are
            believed.
        truth: The boxes of what is there.
    """

    bogus: Points
    truth: Boxes3D
    name: str = LIDAR_ORACLE

    def detect(self, frame: SensorFrame) -> Boxes3D:
        """See `Detector`."""
        # Ranges are noisy, so that no two points share three coordinates.
        left = np.isin(frame.points[:, :3], self.bogus[:, :3]).all(axis=1)
        if left.sum() < _FEWEST_POINTS:
            return self.truth
        places, sent = (
            transform_points(frame.calibration.velodyne_to_camera, points[:, :3])
            for points in (frame.points[left], self.bogus)
        )
        foot = sent[:, 1].max()
        places = places[places[:, 1] < foot - _LOWEST]
        if len(places) < _FEWEST_POINTS:
            return self.truth
        return Boxes3D.concatenate([self.truth, _obstacle(places, foot)])


def _hidden_pixels(image: Image, clean: Image) -> NDArray[np.bool_]:
    change = np.abs(np.subtract(image, clean, dtype=np.int16)).max(axis=2)
    return np.asarray(change > BLINDING)


def _shares(hidden: NDArray[np.bool_], boxes: Boxes3D, projection: Floats) -> Floats:
    """Of each box's area in an image, how much is hidden; 0 outside of it, shape (N,)."""
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    pixels, depth = project(projection, corners)
    ahead = (depth > 0.1)[..., None]
    size = np.array(hidden.shape[::-1])
    low = np.clip(np.where(ahead, pixels, np.inf).min(axis=1), 0, size)
    high = np.clip(np.where(ahead, pixels, -np.inf).max(axis=1), 0, size)
    shares = np.zeros(len(boxes))
    for row, (u, v, u_end, v_end) in enumerate(np.rint(np.hstack([low, high])).astype(int)):
        area = hidden[v:v_end, u:u_end]
        shares[row] = area.mean() if area.size else 0.0
    return shares


def _obstacle(places: Floats, foot: float) -> Boxes3D:
    """What stands where points are, along the car's axes.

    Args:
        places: The places in the camera frame, shape (N, 3).
        foot: Where it meets the road, y.
    """
    low, high = places.min(axis=0), places.max(axis=0)
    high[1] = foot
    width, height, length = np.maximum(high - low, _THINNEST)
    middle = (low + high) / 2
    return Boxes3D(
        location=np.array([[middle[0], high[1], middle[2]]]),
        dimensions=np.array([[height, width, length]]),
        rotation_y=np.array([-np.pi / 2]),
        score=np.ones(1),
        category=np.array(["Misc"]),
    )
