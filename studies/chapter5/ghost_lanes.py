"""In which lane a ghost stands, as seen from where the car wants to go."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.ghost_positions import LANE_WIDTH, in_corridor
from avsec_gym.scenario.intention import Intention


class GhostLane(StrEnum):
    """The lane that a ghost counts in; each counts in one, the first of these that it reaches."""

    OWN = "own lane"
    """The lane that the car is in, which it drives on whatever it intends."""
    GOAL = "goal lane"
    """The lane that it changes to; a car that keeps its lane has no other."""
    ELSEWHERE = "elsewhere"
    """Lanes that it does not need, and beside the road."""


def ghost_lanes(boxes: Boxes3D, intention: Intention) -> list[GhostLane]:
    """The lane of each box.

    Args:
        boxes: Boxes in the camera frame.  Lanes are straight, `LANE_WIDTH` wide, and the car stands
            in the middle of its own: a box reaches into a lane if its footprint does.
        intention: The driving intention.
    """
    own = reaches_into(boxes, Intention.STRAIGHT)
    goal = reaches_into(boxes, intention)
    return [
        GhostLane.OWN if in_own else GhostLane.GOAL if in_goal else GhostLane.ELSEWHERE
        for in_own, in_goal in zip(own, goal, strict=True)
    ]


def reaches_into(boxes: Boxes3D, intention: Intention) -> NDArray[np.bool_]:
    """Which footprints reach into the lane that an intention leads to, shape (N,).

    Args:
        boxes: Boxes in the camera frame.
        intention: The driving intention.
    """
    middle = LANE_WIDTH * intention.lanes_to_the_left
    return in_corridor(boxes, 0.5 * LANE_WIDTH, middle)
