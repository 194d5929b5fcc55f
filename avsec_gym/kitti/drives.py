"""The drives of a folder, whichever of KITTI's layouts it has them in."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from avsec_gym.kitti.layouts import tracking_folders
from avsec_gym.kitti.odometry import KittiOdometry, odometry_folder
from avsec_gym.kitti.raw import KittiRaw, find_raw
from avsec_gym.kitti.recording import Recording
from avsec_gym.kitti.tracking_sequences import KittiTracking


def recorded_drives(root: str | Path) -> Sequence[Recording]:
    """All drives of KITTI raw, or all sequences of the tracking or the odometry benchmark.

    Args:
        root: See `KittiRaw`, `KittiTracking`, `KittiOdometry`.

    Raises:
        DataError: It is none of these.
    """
    root = Path(root)
    if not find_raw(root)[0]:
        if tracking_folders(root):
            tracking = KittiTracking(root)
            return [tracking.sequence(name) for name in tracking.sequences()]
        if odometry_folder(root) is not None:
            odometry = KittiOdometry(root)
            return [odometry.sequence(name) for name in odometry.sequences()]
    raw = KittiRaw(root)
    return [raw.drive(name) for name in raw.drives()]
