"""Boxes as an action of fixed size: up to `max_boxes` rows of eight numbers in [-1, 1]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import whole_number
from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats
from avsec_gym.image_only import check_places

_LOW = np.array([-40.0, -5.0, 0.0, 0.0, 0.0, 0.0, -np.pi])
_HIGH = np.array([40.0, 5.0, 80.0, 5.0, 5.0, 20.0, np.pi])
ROW = 8
MOST_BOXES = 1000
"""A frame of KITTI has some twenty objects; detectors report a few hundred boxes at most."""


@dataclass(frozen=True)
class BoxCoding:
    """Rows of score, x, y, z, h, w, l, ry; each scaled linearly to [-1, 1].

    The score stays as it is: 0 or less is no box.  Places are those of KITTI's camera frame: x in
    -40..40 m, y in -5..5 m, z in 0..80 m; sizes up to 5, 5 and 20 m; ry in -pi..pi.

    Args:
        max_boxes: Rows of an action, at most `MOST_BOXES`.

    Raises:
        ConfigurationError: There is no row, or there are too many.
    """

    max_boxes: int = 50

    def __post_init__(self) -> None:
        count = whole_number("max_boxes", self.max_boxes, 1, MOST_BOXES)
        object.__setattr__(self, "max_boxes", count)

    @property
    def size(self) -> int:
        """Numbers in an action."""
        return ROW * self.max_boxes

    def encode(self, boxes: Boxes3D) -> NDArray[np.float32]:
        """The best boxes as an action, shape (size,); what is out of range is cut to it.

        Boxes with a score of 0 or less are left out; a score above 1 counts as 1.

        Raises:
            ConfigurationError: A box is known in the image only: cut to the range it would stand
                somewhere.
        """
        check_places(boxes)
        order = np.argsort(-boxes.score, kind="stable")
        order = order[boxes.score[order] > 0][: self.max_boxes]
        turned = (boxes.rotation_y[order] + np.pi) % (2 * np.pi) - np.pi
        values = np.column_stack([boxes.location[order], boxes.dimensions[order], turned])
        rows = np.full((self.max_boxes, ROW), -1.0, np.float32)
        rows[: len(order), 0] = np.minimum(boxes.score[order], 1.0)
        rows[: len(order), 1:] = np.clip(2.0 * (values - _LOW) / (_HIGH - _LOW) - 1.0, -1.0, 1.0)
        return rows.ravel()

    def decode(self, action: Floats) -> Boxes3D:
        """The boxes of an action, all of them cars; sizes are at least a centimetre."""
        rows = np.clip(np.asarray(action, float).reshape(-1, ROW), -1.0, 1.0)
        rows = rows[rows[:, 0] > 0]
        values = _LOW + 0.5 * (rows[:, 1:] + 1.0) * (_HIGH - _LOW)
        return Boxes3D(
            location=values[:, :3],
            dimensions=np.maximum(values[:, 3:6], 0.01),
            rotation_y=values[:, 6],
            score=rows[:, 0],
            category=np.full(len(rows), "Car"),
        )
