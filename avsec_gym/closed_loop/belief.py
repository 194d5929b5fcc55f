"""What the car believes, laid out in the world frame for its planner."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.closed_loop.prediction import following_lanes
from avsec_gym.closed_loop.relative_poses import in_world
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.pipeline import Perception
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import GOAL_STEPS, TIME_STEP
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.scene import Motion, matched_speeds


@dataclass(frozen=True, eq=False)
class Belief:
    """N believed objects.

    Args:
        time: Time of the frame that the belief comes from, seconds since the start of the drive.
        poses: x, y, heading in the world frame, shape (N, 3).
        lengths: Lengths, metres, shape (N,).
        widths: Widths, metres, shape (N,).
        speeds: Speeds along the headings that the planner reckons with, m/s, shape (N,).
        road_type: The believed type of the road.
        stops: Whether the car makes an emergency stop, whatever else it believes.
        alarm: Whether the car's validator raises an alarm.
    """

    time: float
    poses: Floats
    lengths: Floats
    widths: Floats
    speeds: Floats
    road_type: RoadType
    stops: bool = False
    alarm: bool = False

    def obstacles(self, lanes: Lanes | None = None, last_step: int = GOAL_STEPS[1]) -> Obstacles:
        """The objects at constant velocity from now on; after the last time step they stand.

        Args:
            lanes: Lanes that are followed where they bend; None: every object keeps its heading.
            last_step: Time step up to which they move; that of the planner's horizon by itself.
        """
        straight = Obstacles.rectangles(
            self.poses,
            self.lengths,
            self.widths,
            self.speeds,
            dt=TIME_STEP,
            last_step=last_step,
        )
        return straight if lanes is None else following_lanes(straight, lanes, TIME_STEP)


def belief_of(perception: Perception, surroundings: Surroundings, motion: Motion) -> Belief:
    """What a perception means to the planner.

    Args:
        perception: What the car perceived; objects of every class are obstacles.
        surroundings: The truth at that instant: the car's own pose, and true speeds for
            `Motion.TRUTH`.
        motion: The planner's knowledge of motion, as in a single query.

    Raises:
        ConfigurationError: Motion is to come from a classifier, and the boxes have no `moving`.
    """
    boxes = perception.believed
    boxes = boxes[np.all(boxes.dimensions[:, 1:] > 0, axis=1)]
    road_type = perception.road_type or surroundings.road_type
    if perception.stops:  # A car that trusts nothing has classified nothing.
        speeds = np.zeros(len(boxes))
    elif motion == Motion.TRUTH:
        speeds = matched_speeds(boxes, surroundings.boxes, surroundings.speeds)
    elif motion == Motion.CLASSIFIER:
        if boxes.moving is None:
            raise ConfigurationError(
                "motion by a classifier needs boxes with `moving`: name a classifier"
            )
        speeds = np.where(boxes.moving, np.mean(driving_constraints(road_type).others_speed), 0.0)
    else:
        speeds = np.zeros(len(boxes))
    return Belief(
        time=surroundings.time,
        poses=in_world(surroundings.pose, boxes.poses),
        lengths=boxes.length,
        widths=boxes.width,
        speeds=speeds,
        road_type=road_type,
        stops=perception.stops,
        alarm=perception.validation is not None and perception.validation.alarm,
    )
