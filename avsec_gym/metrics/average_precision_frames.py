"""KITTI's rules for what counts: difficulty levels, neighbouring classes, small detections.

All frames of a data set lie one after another in flat arrays, so that the kernels of
`average_precision_matching` run over them without touching Python.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import ground_rectangles
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.image_only import is_image_only

LEVELS = ("easy", "moderate", "hard")
"""Cumulative: what is easy is also moderate and hard."""
MIN_HEIGHT = (40.0, 25.0, 25.0)
"""Pixels; labels must be higher, detections at least as high."""
MAX_OCCLUSION = (0.0, 1.0, 2.0)
MAX_TRUNCATION = (0.15, 0.30, 0.50)
NEIGHBOURS = {"car": "van", "pedestrian": "person_sitting"}
"""Labels of these classes are neither to be found nor false alarms."""

COUNTED, IGNORED, OTHER = 0, 1, -1
"""What an object is to a class and level: judged; neither right nor wrong; not looked at."""

CountStatus = NDArray[np.int8]


class Extents(NamedTuple):
    """Where the N objects of F frames are, frame after frame: the input of numba kernels."""

    first: NDArray[np.int64]
    """Frame f holds the objects first[f] to first[f + 1], shape (F + 1,)."""
    box2d: Floats
    """Left, top, right, bottom, pixels, shape (N, 4)."""
    ground: Floats
    """x, z, length, width, heading, shape (N, 5)."""
    vertical: Floats
    """Top and bottom in the camera's y, which points down, shape (N, 2)."""


@dataclass(frozen=True, eq=False)
class Objects:
    """The N labels or detections of F frames."""

    extents: Extents
    category: NDArray[np.str_]
    """Lower case, as the development kit compares without case, shape (N,)."""
    score: Floats
    alpha: Floats
    """NaN where unknown, shape (N,)."""
    truncation: Floats
    occlusion: Floats
    image_only: NDArray[np.bool_]
    """Known in the image only, without a place in space, shape (N,)."""

    @property
    def height(self) -> Floats:
        """The heights of the 2D boxes, pixels, shape (N,)."""
        return self.extents.box2d[:, 3] - self.extents.box2d[:, 1]

    @property
    def frame(self) -> NDArray[np.int64]:
        """The frame of each object, shape (N,)."""
        sizes = np.diff(self.extents.first)
        return np.repeat(np.arange(len(sizes)), sizes)


def pooled(frames: Sequence[Boxes3D], what: str) -> Objects:
    """Frames one after another.

    Args:
        frames: Boxes of each frame.
        what: Name of the boxes, for messages.

    Raises:
        ConfigurationError: There are boxes without 2D boxes.
    """
    for i, boxes in enumerate(frames):
        if boxes.box2d is None and len(boxes):
            raise ConfigurationError(
                f"average precision needs 2D boxes, whose height decides what counts; the {what}"
                f" of frame {i} (from 0) have none: fill Boxes3D.box2d"
            )
    location = _column(frames, "location", (3,))
    dimensions = _column(frames, "dimensions", (3,))
    alpha = _column(frames, "alpha", (), unknown=-10.0)
    category = [boxes.category for boxes in frames if len(boxes)]
    return Objects(
        Extents(
            first=np.cumsum([0, *map(len, frames)]),
            box2d=_column(frames, "box2d", (4,)),
            ground=ground_rectangles(location, dimensions, _column(frames, "rotation_y", ())),
            vertical=location[:, 1:2] - dimensions[:, :1] * [1.0, 0.0],
        ),
        category=np.char.lower(np.concatenate(category) if category else np.zeros(0, np.str_)),
        score=_column(frames, "score", ()),
        alpha=np.where(alpha == -10.0, np.nan, alpha),
        truncation=_column(frames, "truncation", (), unknown=-1.0),
        occlusion=_column(frames, "occlusion", (), unknown=-1.0),
        image_only=np.concatenate([np.zeros(0, bool), *map(is_image_only, frames)]),
    )


def label_status(labels: Objects, category: str, level: int) -> CountStatus:
    """What each label is to a class at a level, shape (N,)."""
    own = labels.category == category.lower()
    neighbour = labels.category == NEIGHBOURS.get(category.lower())
    passes = (
        (labels.height > MIN_HEIGHT[level])
        & (labels.occlusion <= MAX_OCCLUSION[level])
        & (labels.truncation <= MAX_TRUNCATION[level])
    )
    return np.select([own & passes, own | neighbour], [COUNTED, IGNORED], OTHER).astype(np.int8)


def detection_status(detections: Objects, category: str, level: int) -> CountStatus:
    """What each detection is to a class at a level, shape (N,); too small comes before class."""
    small = np.abs(detections.height) < MIN_HEIGHT[level]
    own = detections.category == category.lower()
    return np.select([small, own], [IGNORED, COUNTED], OTHER).astype(np.int8)


def _column(
    frames: Sequence[Boxes3D], name: str, tail: tuple[int, ...], unknown: float = 0.0
) -> Floats:
    """A field of all boxes; `unknown` where a frame lacks it."""
    parts = []
    for boxes in frames:
        if len(boxes):
            value = getattr(boxes, name)
            parts.append(np.full((len(boxes), *tail), unknown) if value is None else value)
    return np.ascontiguousarray(np.concatenate(parts)) if parts else np.zeros((0, *tail))
