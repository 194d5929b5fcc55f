"""The labelled boxes of a frame's image, as average precision takes them."""

from __future__ import annotations

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.objects.object_mismatches import boxes_seen_by
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.labels import read_labels
from avsec_gym.kitti.raw import TRACKLETS, Drive


def truth_of(frame: SensorFrame, camera: int) -> Boxes3D | None:
    """Labels with 2D boxes, and the regions not to care about; None without labels.

    Procedural drives have labels of camera 2, which is the reference of chapter 3.  A real one has
    tracklets, whose 2D boxes are those of their projected corners.

    Args:
        frame: A frame of a drive, as its reader gives it.
        camera: The reference camera.

    Raises:
        DataError: A file is broken.
    """
    if frame.origin is None:
        return None
    labels = frame.origin / f"label_{camera:02d}" / "data" / f"{frame.id}.txt"
    if labels.is_file():
        return read_labels(labels, keep_dont_care=True)
    if not (frame.origin / TRACKLETS).is_file():
        return None
    height, width = frame.image(camera).shape[:2]
    boxes = Drive(frame.origin).labels(int(frame.id))
    return boxes_seen_by(boxes, frame.calibration.projection(camera), (height, width))
