"""A frame as a recording for the Rerun viewer: cameras, scan, boxes true and believed."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.rerun_stream import (
    corners_in_velodyne,
    log_boxes,
    log_camera,
    log_points,
    recording,
)
from avsec_gym.drawing.scenario_picture import BELIEVED, REAL
from avsec_gym.frame import SensorFrame


def write_frame_recording(
    frame: SensorFrame, path: Path, true: Boxes3D | None = None, believed: Boxes3D | None = None
) -> None:
    """Write all sensors of a frame, in the velodyne frame.

    Args:
        frame: The frame; what it lacks is left out.
        path: The file, ``.rrd``; one that is there is replaced.
        true: The labelled objects.
        believed: What a detector reports; each has its score beside it.

    Raises:
        ConfigurationError: Rerun's SDK is not installed.
        DataError: An image or the scan is broken.
    """
    calibration = frame.calibration
    with recording(path, f"frame {frame.id}") as stream:
        import rerun as rr

        stream.log("/", rr.ViewCoordinates.FLU, static=True)
        if frame.has_points:
            log_points(stream, "lidar", frame.points)
        for camera in sorted(set(frame.images) & set(calibration.cameras)):
            log_camera(stream, f"camera_{camera}", frame.image(camera), calibration, camera)
        if true is not None:
            labels = true.category.tolist()
            log_boxes(stream, "true", corners_in_velodyne(true, calibration), REAL, labels)
        if believed is not None:
            pairs = zip(believed.category.tolist(), believed.score.tolist(), strict=True)
            labels = [f"{name} {score:.2f}" for name, score in pairs]
            corners = corners_in_velodyne(believed, calibration)
            log_boxes(stream, "believed", corners, BELIEVED, labels)
