"""Recall in which an object counts the more, the sooner the car would touch it.

After Ceccarelli and Montecchi, "Evaluating Object (Mis)Detection From a Safety and Reliability
Perspective: Discussion and Measures", IEEE Access 2023: what is missed far from the car's way, or
long before it could be reached, matters less, by distance and by time to collision.

How this departs from it: there objects have measured speeds, and distance, closest approach and
time to collision are joined by tuned bounds.  Here the car goes on at its start speed along the
straight line to its goal; an object weighs 1 / (1 + t / s) by the time t until the car comes within
`MARGIN` of it, and nothing if that takes more than `HORIZON`.  Believed objects that are not real
weigh likewise, which the original leaves to a precision of its own.
"""

from __future__ import annotations

import numpy as np
import shapely

from avsec_gym.geometry import Floats, rectangle_polygons
from avsec_gym.metrics.collision_check import present_poses, shapes_at
from avsec_gym.planners.vehicle import BMW_320I, Vehicle
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.shapes import Rectangle

MARGIN = 0.5
"""The distance within which an object counts as touched, metres."""
HORIZON = 3.0
"""The time after which a contact weighs nothing, seconds; goals are open for as long."""


def contact_weights(scenario: PlanningScenario, vehicle: Vehicle = BMW_320I) -> Floats:
    """The weight of each obstacle by the time until the car comes near it, shape (N,).

    Args:
        scenario: Start, one goal with a rectangle, and obstacles.
        vehicle: The vehicle, of which the size counts.

    Returns:
        1 where the car stands within `MARGIN` of it, 1 / 2 after a second, 0 beyond `HORIZON`.
    """
    obstacles = scenario.obstacles
    if not len(obstacles):
        return np.zeros(0)
    poses = straight_way(scenario)
    present, others = present_poses(len(poses), obstacles, scenario.start.step)
    own = rectangle_polygons(poses, vehicle.length, vehicle.width)
    weights = np.zeros(len(obstacles))
    for i in range(len(obstacles)):
        areas = shapes_at(obstacles.shapes, np.full(len(poses), i), others[:, i])
        near = present[:, i] & (shapely.distance(own, areas) <= MARGIN)
        if near.any():
            weights[i] = 1 / (1 + float(near.argmax()) * scenario.dt)
    return weights


def straight_way(scenario: PlanningScenario) -> Floats:
    """Where the car is that goes on at its start speed straight to its goal and beyond it.

    Returns:
        x, y, heading at every time step of `HORIZON`, shape (T, 3).
    """
    start, (goal,) = scenario.start, scenario.goals
    (region,) = goal.region or (None,)
    assert isinstance(region, Rectangle), "goal regions are rectangles"
    heading = np.arctan2(region.y - start.y, region.x - start.x)
    driven = start.velocity * scenario.dt * np.arange(round(HORIZON / scenario.dt) + 1)
    return np.column_stack(
        [
            start.x + driven * np.cos(heading),
            start.y + driven * np.sin(heading),
            np.full(len(driven), heading),
        ]
    )
