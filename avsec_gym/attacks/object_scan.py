"""`ObjectScan`: what a LiDAR saw of one object, cut out of a frame, and its file."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Points, SensorFrame
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.rig import SensorRig
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.npz_files import read_npz
from avsec_gym.storage.regular_files import is_there

_MOST_BYTES = 64 * 2**20
_FARTHEST = 1000.0
_REMEDY = (
    "Cut one out of a frame: `write_object_scan(FILE, cut_out(frame, box))` of "
    "avsec_gym.attacks.object_scan."
)


@dataclass(frozen=True, eq=False)
class ObjectScan:
    """What a LiDAR saw of one object.

    Args:
        points: Points in the object's own frame, shape (M, 4): x along its heading, y to its left,
            z up from the middle of its bottom, metres; reflectance.
        dimensions: Height, width, length of its box, metres.
        seen_from: Place of the LiDAR in that frame, x and y, metres: it saw the sides that face it.

    Raises:
        ConfigurationError: No points, a value that is not finite, a point or the LiDAR beyond a
            kilometre, a reflectance that is not from 0 to 1, or a box that is no object's.
    """

    points: Points
    dimensions: tuple[float, float, float]
    seen_from: tuple[float, float]

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 4 or not len(self.points):
            raise ConfigurationError(
                f"the scan of an object has shape (M, 4), M > 0, got {self.points.shape}"
            )
        if not (np.isfinite(self.points).all() and np.isfinite(self.seen_from).all()):
            raise ConfigurationError("the scan of an object holds a value that is not finite")
        metres = np.r_[self.points[:, :3].ravel(), self.seen_from, self.dimensions]
        if not np.abs(metres).max() <= _FARTHEST:
            raise ConfigurationError(
                f"an object lies within {_FARTHEST:g} m, and so does the LiDAR"
            )
        if not ((self.points[:, 3] >= 0) & (self.points[:, 3] <= 1)).all():
            raise ConfigurationError("reflectance is from 0 to 1")
        if not (len(self.dimensions) == 3 and min(self.dimensions) > 0):
            raise ConfigurationError(f"a box has three positive sizes, got {self.dimensions}")


def cut_out(frame: SensorFrame, box: Boxes3D) -> ObjectScan:
    """An object's points out of a frame's scan.

    Args:
        frame: A frame with a scan.
        box: Box of one object, such as ``labels[[3]]``.

    Raises:
        ConfigurationError: Not one box.
        DataError: No scan, or no point of it in the box.
    """
    if len(box) != 1:
        raise ConfigurationError(f"one object is cut out at a time, got {len(box)}")
    rig = SensorRig(frame.calibration)
    height, width, length = (float(size) for size in box.dimensions[0])
    bottom = rig.camera_height - float(box.location[0, 1])
    to_own = np.linalg.inv(object_pose(box.poses[0], bottom)) @ rig.velodyne_pose
    scan = cut_out_points(frame.points, to_own, (height, width, length))
    if scan is None:
        raise DataError(
            f"Frame {frame.id} has no point of its scan in the box at {box.location[0].round(1)}.",
            path=frame.origin,
            remedy="Cut out an object that the LiDAR sees.",
        )
    return scan


def cut_out_points(
    points: Points, to_own: Floats, dimensions: tuple[float, float, float], feet: float = 0.0
) -> ObjectScan | None:
    """An object's points out of a scan; None where there is none.

    Args:
        points: The scan, velodyne frame, shape (M, 4).
        to_own: Transform from the velodyne frame to the object's own, shape (4, 4).
        dimensions: Height, width, length of its box, metres.
        feet: Points lower than this above its bottom are the ground's, metres.
    """
    height, width, length = dimensions
    places = transform_points(to_own, points[:, :3])
    inside = (np.abs(places[:, 0]) <= length / 2) & (np.abs(places[:, 1]) <= width / 2)
    inside &= (places[:, 2] >= feet) & (places[:, 2] <= height)
    if not inside.any():
        return None
    own = np.c_[places[inside], points[inside, 3]].astype(np.float32)
    return ObjectScan(own, dimensions, (to_own[0, 3], to_own[1, 3]))


def write_object_scan(path: str | Path, scan: ObjectScan, *, overwrite: bool = False) -> None:
    """Write a scan as NumPy's ``.npz`` of ``points``, ``dimensions`` and ``seen_from``.

    A file of points alone, as KITTI's ``.bin``, would not hold where the object is among them.

    Raises:
        DataError: The file exists and `overwrite` is false, or it cannot be written.
    """
    content = io.BytesIO()
    np.savez_compressed(
        content, points=scan.points, dimensions=scan.dimensions, seen_from=scan.seen_from
    )
    write_bytes(path, content.getvalue(), overwrite=overwrite)


def read_object_scan(path: str | Path) -> ObjectScan:
    """Read what `write_object_scan` wrote.

    Raises:
        DataError: Missing, cut off, or something else.
    """
    if not is_there(path):
        raise DataError("There is no scan of an object here.", path=path, remedy=_REMEDY)
    arrays = read_npz(path, most=_MOST_BYTES, remedy=_REMEDY)
    missing = {"points", "dimensions", "seen_from"} - set(arrays)
    if missing:
        raise DataError(
            f"This is no scan of an object: it lacks {sorted(missing)[0]}.",
            path=path,
            remedy=_REMEDY,
        )
    shapes = {"dimensions": (3,), "seen_from": (2,), "points": (*arrays["points"].shape[:1], 4)}
    for name, shape in shapes.items():
        if arrays[name].dtype.kind not in "fiu" or arrays[name].shape != shape:
            raise DataError(
                f"This is no scan of an object: its {name} are {arrays[name].dtype} of shape "
                f"{arrays[name].shape}.",
                path=path,
                remedy=_REMEDY,
            )
    height, width, length = map(float, arrays["dimensions"])
    ahead, left = map(float, arrays["seen_from"])
    try:
        points = arrays["points"].astype(np.float32)
        return ObjectScan(points, (height, width, length), (ahead, left))
    except ConfigurationError as error:
        raise DataError(
            f"This is no scan of an object ({error}).", path=path, remedy=_REMEDY
        ) from error


def object_pose(pose: Floats, bottom: float) -> Floats:
    """The transform from an object's own frame to the vehicle frame, shape (4, 4)."""
    x, y, heading = pose
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array([[cos, -sin, 0, x], [sin, cos, 0, y], [0, 0, 1, bottom], [0, 0, 0, 1]])
