"""Traffic of KITTI raw drives: tracklets, and the car's motion where all its oxts are there."""

from __future__ import annotations

import numpy as np

from avsec_gym.closed_loop.recorded.recorded_motion import motion_from_oxts
from avsec_gym.closed_loop.recorded.recorded_traffic import RecordedTraffic
from avsec_gym.closed_loop.recorded.tracking_traffic import traffic_of_frames
from avsec_gym.geometry import Floats
from avsec_gym.kitti.raw import OXTS, Drive
from avsec_gym.kitti.tracking import TrackedBoxes
from avsec_gym.kitti.tracklets import tracklet_boxes


def drive_traffic(drive: Drive) -> RecordedTraffic:
    """The traffic of a drive; where oxts of a frame are missing, its motion is unknown.

    Args:
        drive: A drive with tracklets, and the calibration of its day.

    Raises:
        DataError: There are no tracklets or no calibration, or a file is broken.
    """
    tracklets = drive.tracklets
    last = max((tracklet.frames[-1] for tracklet in tracklets), default=-1)
    measured = drive.sensors.get(OXTS, ())
    count = max(last + 1, measured[-1] + 1 if measured else 0)
    frames = {}
    for frame in range(last + 1):
        ids = [number for number, each in enumerate(tracklets) if frame in each.frames]
        boxes = tracklet_boxes(tracklets, frame, drive.calibration)
        frames[frame] = TrackedBoxes(boxes, np.array(ids, np.int64))
    motion: Floats | None = None
    if len(measured) == count:
        motion = motion_from_oxts(drive.oxts, drive.calibration)
    return traffic_of_frames(drive.name, count, frames, motion)
