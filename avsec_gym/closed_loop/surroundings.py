"""What is really around the car at one instant, and how its sensors would see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.relative_poses import Pose
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The truth at one instant of a drive; perception makes beliefs of it.

    Args:
        time: Seconds since the start of the drive.
        pose: x, y, heading of the car's centre in the world frame.
        speed: The car's speed, m/s.
        boxes: All others, in the camera frame of the car at this instant; the camera stands at the
            car's centre, as in the thesis' conversion of labels.
        speeds: Speed of each along its heading, m/s, shape (N,).
        actors: Id of each, the same over the whole drive, shape (N,).
        road_type: Street or highway.
        intention: Where the car wants to go; attacks may depend on it.
        scenario: Id of the scene.
        frame: Renders or reads what the sensors deliver, when it is called; None: there is no
            sensor data.
    """

    time: float
    pose: Pose
    speed: float
    boxes: Boxes3D
    speeds: Floats
    actors: NDArray[np.int64]
    road_type: RoadType
    intention: Intention = Intention.STRAIGHT
    scenario: str = ""
    frame: Callable[[], SensorFrame] | None = None
