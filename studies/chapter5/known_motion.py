"""Boxes whose motion is known, for planners that take the motion from a classifier."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.boxes import Boxes3D


def with_known_motion(boxes: Boxes3D) -> Boxes3D:
    """The same boxes; where it is not known which of them move, they stand.

    Labels of data sets without flags, ghosts and corrected boxes have none.

    Example:
        >>> with_known_motion(Boxes3D.empty()).moving
        array([], dtype=bool)
    """
    if boxes.moving is not None:
        return boxes
    return replace(boxes, moving=np.zeros(len(boxes), bool))
