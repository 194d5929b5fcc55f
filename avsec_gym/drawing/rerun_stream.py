"""Recordings for the Rerun viewer: a file that is begun, and what several of them show."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, Image, Points
from avsec_gym.geometry import Floats, box_corners, transform_points
from avsec_gym.storage.folders import make_folder

_EDGES = [(0, 1, 2, 3, 0, 4, 5, 6, 7, 4), (1, 5), (2, 6), (3, 7)]
"""The edges of a box, by the corners of `box_corners`: both faces in one stroke, then three
uprights."""
_DARK, _BRIGHT = np.array([60.0, 75.0, 95.0]), np.array([250.0, 225.0, 120.0])
_JPEG_QUALITY = 85


def check_rerun() -> None:
    """Refuse to begin what could not be recorded.

    Raises:
        ConfigurationError: Rerun's SDK is not installed.
    """
    try:
        import rerun  # noqa: F401
    except ImportError:
        raise ConfigurationError(
            "recordings for Rerun need its SDK: pip install 'avsec-gym[rerun]'"
        ) from None


@contextmanager
def recording(path: Path, name: str) -> Iterator[Any]:
    """A recording that goes to a file, which is complete when this ends.

    Args:
        path: The file, ``.rrd``; one that is there is replaced.
        name: What the viewer calls it.

    Raises:
        ConfigurationError: Rerun's SDK is not installed.
    """
    check_rerun()
    import rerun as rr

    make_folder(path.parent)
    stream = rr.RecordingStream(name)
    stream.save(str(path))
    yield stream
    stream.flush()


def colour(text: str) -> list[int]:
    """Red, green and blue of a colour such as ``#D7263D``."""
    return [int(text[at : at + 2], 16) for at in (1, 3, 5)]


def log_points(stream: Any, entity: str, points: Points, pose: Floats | None = None) -> None:
    """A LiDAR scan, brighter where it reflects more.

    Args:
        stream: The recording.
        entity: Where it stands in it.
        points: The scan, velodyne frame, shape (M, 4).
        pose: The transform from the velodyne frame to that of the recording; None: the same.
    """
    import rerun as rr

    places = points[:, :3] if pose is None else transform_points(pose, points[:, :3])
    share = np.clip(points[:, 3:4], 0, 1)
    colours = (_DARK + share * (_BRIGHT - _DARK)).astype(np.uint8)
    stream.log(entity, rr.Points3D(places, colors=colours, radii=0.03))


def log_boxes(
    stream: Any,
    entity: str,
    corners: Floats,
    shown: str | Sequence[str],
    labels: Sequence[str] | None = None,
) -> None:
    """Boxes as their edges.

    Args:
        stream: The recording.
        entity: Where they stand in it.
        corners: The boxes' corners in the recording's frame as `box_corners` orders them,
            shape (N, 8, 3).
        shown: A colour for all, or for each.
        labels: A text for each.
    """
    import rerun as rr

    strips = [box[list(edge)] for box in corners for edge in _EDGES]
    every = [shown] * len(corners) if isinstance(shown, str) else list(shown)
    colours = [colour(own) for own in every for _ in _EDGES]
    words = None
    if labels is not None:
        words = [text if i == 0 else "" for text in labels for i in range(len(_EDGES))]
    stream.log(entity, rr.LineStrips3D(strips, colors=colours, labels=words, radii=0.04))


def corners_in_velodyne(boxes: Boxes3D, calibration: Calibration) -> Floats:
    """The corners of boxes in the velodyne frame, shape (N, 8, 3)."""
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    return transform_points(calibration.camera_to_velodyne, corners)


def log_camera(
    stream: Any, entity: str, image: Image, calibration: Calibration, camera: int
) -> None:
    """A camera where it is, in the velodyne frame, with its image."""
    import rerun as rr

    projection = calibration.projection(camera)
    pose = calibration.camera_to_velodyne.copy()
    pose[:3, 3] = transform_points(pose, calibration.camera_centre(camera))
    stream.log(entity, rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
    height, width = image.shape[:2]
    stream.log(
        entity,
        rr.Pinhole(
            image_from_camera=projection[:, :3],
            resolution=[width, height],
            camera_xyz=rr.ViewCoordinates.RDF,
        ),
    )
    stream.log(entity, rr.Image(image).compress(jpeg_quality=_JPEG_QUALITY))
