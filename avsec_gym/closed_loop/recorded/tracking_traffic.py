"""Traffic of the KITTI tracking benchmark: labels, and the car's motion where oxts are there."""

from __future__ import annotations

import numpy as np

from avsec_gym.closed_loop.recorded.recorded_motion import motion_from_oxts
from avsec_gym.closed_loop.recorded.recorded_traffic import RecordedTraffic, recorded_object
from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.kitti.tracking import TrackedBoxes
from avsec_gym.kitti.tracking_sequences import OXTS, TrackingSequence
from avsec_gym.storage.regular_files import is_file


def sequence_traffic(sequence: TrackingSequence) -> RecordedTraffic:
    """The traffic of a sequence.

    Args:
        sequence: One with labels; oxts are read where they are there.

    Raises:
        DataError: There are no labels, a file is broken, or the oxts end before the labels.
    """
    frames = sequence.tracks
    count, motion = max(frames, default=-1) + 1, None
    path = sequence.folder / OXTS / f"{sequence.name}.txt"
    if is_file(path):
        if len(sequence.oxts) < count:
            raise DataError(
                f"There are {len(sequence.oxts)} measurements for {count} labelled frames.",
                path=path,
                remedy="The file may be cut off; fetch it again.",
            )
        count = len(sequence.oxts)
        motion = motion_from_oxts(sequence.oxts, sequence.calibration)
    return traffic_of_frames(sequence.name, count, frames, motion)


def traffic_of_frames(
    id: str, count: int, frames: dict[int, TrackedBoxes], motion: Floats | None
) -> RecordedTraffic:
    """The traffic of tracked boxes.

    Args:
        id: Name of the sequence or drive.
        count: Number of frames.
        frames: Boxes in the camera frame, and whose they are, by frame.
        motion: The car's own motion, see `RecordedTraffic`.
    """
    rows: dict[int, list[tuple[int, int]]] = {}
    for frame, tracked in frames.items():
        for row, track in enumerate(tracked.tracks.tolist()):
            rows.setdefault(track, []).append((frame, row))
    poses = {frame: tracked.boxes.poses for frame, tracked in frames.items()}
    objects = []
    for track, places in sorted(rows.items()):
        boxes = [(frames[frame].boxes, row) for frame, row in places]
        if not all((each.dimensions[row] > 0).all() for each, row in boxes):
            continue  # Known in the image alone.
        objects.append(
            recorded_object(
                track,
                str(boxes[0][0].category[boxes[0][1]]),
                np.array([each.dimensions[row] for each, row in boxes]),
                [frame for frame, _ in places],
                np.array([poses[frame][row] for frame, row in places]),
                np.array([each.location[row, 1] for each, row in boxes]),
            )
        )
    return RecordedTraffic(id, count, tuple(objects), motion)
