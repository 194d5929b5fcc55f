"""What the left camera showed while a car drove, with the boxes that the car believed then."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np

from avsec_gym.attacks.attack import LEFT
from avsec_gym.drawing.embedded_image import webp
from avsec_gym.drawing.frame_picture import with_boxes
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.folders import make_folder
from avsec_gym.storage.regular_files import is_folder, read_bytes

VIEWS = "views"
"""The folder of the views in a folder of drives; each drive has one of its own there."""
_WIDTH = 621
"""Pixels: half of a KITTI image."""
_MOST_BYTES = 2**22


class CameraViews:
    """Collects the views of one drive, one for each frame that its car has looked at.

    Args:
        played: The environment, unwrapped.
    """

    def __init__(self, played: Any) -> None:
        self._played = played
        self.pictures: dict[int, bytes] = {}
        """WebP files by the milliseconds since the start of the drive."""

    def look(self) -> None:
        """Keep what the camera shows, if the car has an image of this instant."""
        perception, belief = self._played.perception, self._played.belief
        frame = getattr(perception, "frame", None)
        time = round(1000 * self._played.elapsed)
        if frame is None or LEFT not in frame.images or round(1000 * belief.time) != time:
            return
        believed = perception.perceived.believed
        image = with_boxes(frame.image(LEFT), believed, frame.calibration, LEFT)
        size = (_WIDTH, round(_WIDTH * image.shape[0] / image.shape[1]))
        small = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)
        self.pictures[time] = webp(small)


def write_views(out: Path, id: str, pictures: dict[int, bytes]) -> None:
    """Keep the views of a drive, and none that were there before.

    Args:
        out: The folder of the drives.
        id: The drive's id.
        pictures: WebP files by the milliseconds since the start.
    """
    folder = _folder(out, id)
    if is_folder(folder):
        shutil.rmtree(folder)
    if pictures:
        make_folder(folder)
    for time, content in pictures.items():
        write_bytes(folder / f"{time:06d}.webp", content, overwrite=True)


class CameraView(NamedTuple):
    """One view.

    Args:
        time: Seconds since the start of the drive.
        content: A WebP file.
    """

    time: float
    content: bytes


def view_until(out: Path, id: str, time: float | None = None) -> CameraView | None:
    """The last view of a drive until a time; None: there is none.

    Args:
        out: The folder of the drives.
        id: The drive's id.
        time: Seconds since the start; None: its end.
    """
    folder = _folder(out, id)
    if not is_folder(folder):
        return None
    files = {int(path.stem): path for path in folder.glob("*.webp") if path.stem.isdecimal()}
    until = math.inf if time is None else 1000 * time + 1e-6
    last = max((each for each in files if each <= until), default=None)
    if last is None:
        return None
    return CameraView(last / 1000, read_bytes(files[last], most=_MOST_BYTES))


def _folder(out: Path, id: str) -> Path:
    return out / VIEWS / id.replace("/", "_")
