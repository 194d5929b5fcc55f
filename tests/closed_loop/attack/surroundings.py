"""A car at a pose, with two cars around it: no test module."""

from __future__ import annotations

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.relative_poses import Pose, seen_from
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.geometry import ego_to_camera
from avsec_gym.road_type import RoadType

OTHERS = np.array([[30.0, 0.0, 0.0], [20.0, 3.5, 0.0]])
"""World poses of the actors 7 and 9."""


def around(pose: Pose, others: np.ndarray = OTHERS) -> Surroundings:
    location, rotation_y = ego_to_camera(seen_from(pose, others), 1.65)
    count = len(others)
    boxes = Boxes3D(
        location=location,
        dimensions=np.tile([1.5, 1.7, 4.0], (count, 1)),
        rotation_y=rotation_y,
        score=np.ones(count),
        category=np.full(count, "Car"),
        moving=np.zeros(count, bool),
    )
    actors = np.array([7, 9])[:count]
    return Surroundings(
        1.2, pose, 6.0, boxes, np.zeros(count), actors, RoadType.STREET, scenario="a"
    )
