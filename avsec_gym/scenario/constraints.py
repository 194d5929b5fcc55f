"""The driving-constraint selector's two answers: what a street and a highway allow.

Thesis, section 5.3.1: ``(s_0, r, d) = S(I_l, I_r)`` gives the initial state, the speed range and
the vehicle dynamics.  The numbers are those of the authors' labelled scenarios.
"""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.road_type import RoadType


@dataclass(frozen=True)
class DrivingConstraints:
    """What a road type asks of the ego vehicle and expects of others (m/s)."""

    start_speed: float
    """The ego vehicle's speed at the start."""
    start_speed_range: tuple[float, float]
    """The thesis draws the start speed uniformly from here (22..29 and 40..47 km/h)."""
    goal_velocity: tuple[float, float]
    """The allowed speed range r: what the goal accepts."""
    others_speed: tuple[float, float]
    """Moving objects drive at a constant speed drawn uniformly from here."""
    primitive_speeds: tuple[float, ...]
    """Grid of speeds that the motion primitives connect."""


_CONSTRAINTS = {
    RoadType.STREET: DrivingConstraints(
        start_speed=6.0,
        start_speed_range=(22 / 3.6, 29 / 3.6),
        goal_velocity=(6.0, 8.0),
        others_speed=(6.0, 8.0),
        primitive_speeds=(6.0, 8.0),
    ),
    RoadType.HIGHWAY: DrivingConstraints(
        start_speed=11.0,
        start_speed_range=(40 / 3.6, 47 / 3.6),
        goal_velocity=(11.0, 13.0),
        others_speed=(11.0, 13.0),
        primitive_speeds=(11.0, 13.0),
    ),
}


def driving_constraints(road_type: RoadType) -> DrivingConstraints:
    """The constraints that belong to a road type."""
    return _CONSTRAINTS[RoadType(road_type)]
