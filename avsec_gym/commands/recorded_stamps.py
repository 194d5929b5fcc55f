"""What distinguishes recordings of one name: a kept result is of a frame as it was when judged."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.errors import DataError
from avsec_gym.frame import LazyImages

if TYPE_CHECKING:
    from avsec_gym.sensor_system import SensorSystem
    from avsec_gym.validation.connected.recordings import RecordedInstant
    from avsec_gym.validation.recordings import RecordedFrame

_DIGITS, _DECIMALS = 16, 4
"""Hexadecimal digits of a stamp; decimals of a pose, of which the last is 0.1 mm."""


def frame_stamps(frames: Iterable[RecordedFrame], system: SensorSystem) -> dict[str, str]:
    """Digits by the frames' ids that change with the size or time of a sensor's file, or the rig.

    Empty where the calibration cannot be read: no result is of such a frame.

    Args:
        frames: The frames; none of their images and scans is read.
        system: The sensors whose files count.
    """
    return {recorded.id: _stamp(recorded, system) for recorded in frames}


def _stamp(recorded: RecordedFrame, system: SensorSystem) -> str:
    from avsec_gym.perception.training.prepared_once import fingerprint

    try:
        frame = recorded.frame()
    except DataError:
        return ""
    images, rig = frame.images, frame.calibration
    matrices = rig.projections, rig.r0_rect, rig.tr_velo_to_cam
    files = [
        images.path(camera)
        for camera in system.cameras
        if isinstance(images, LazyImages) and camera in images
    ]
    files += [getattr(frame.scan, "path", None)] if system.has_lidar else []
    rows = [matrix.tolist() for matrix in matrices]
    return fingerprint(rows, [file for file in files if file is not None])[:_DIGITS]


def instant_stamp(instant: RecordedInstant) -> str:
    """Digits that change with the scans of connected vehicles, their poses, or the truth.

    Args:
        instant: The instant, whose scans are in memory.
    """
    digest = hashlib.sha256(repr(instant.truth).encode())
    for scan in instant.scans:
        sweep = scan.sweep
        digest.update(np.ascontiguousarray(scan.points).tobytes())
        digest.update(_rounded([scan.time, sweep.speed, sweep.turn_rate, sweep.period]))
        digest.update(_rounded(scan.pose) + bytes([scan.roadside]))
    for pose in instant.true_poses:
        digest.update(_rounded(pose))
    return digest.hexdigest()[:_DIGITS]


def _rounded(numbers: ArrayLike) -> bytes:
    """Without the last bits, which differ where poses are registered; zeros have one sign."""
    return (np.round(np.asarray(numbers, np.float64), _DECIMALS) + 0.0).tobytes()
