"""`DriveRow`: what is kept of a drive beside its film, a line of JSON each."""

from __future__ import annotations

from typing import Literal, TypedDict

from avsec_gym.closed_loop.drive_record import Outcome


class DriveRow(TypedDict):
    """What became of a drive; the numbers are those of the environment's info at its end.

    None stands where a number is not finite: there is no such thing, or never one near.
    """

    id: str
    """The id of the drive, ``setting/scenario/intention``."""
    setting: str
    scenario: str
    intention: str
    seed: int
    steps: int
    duration: float
    outcome: Outcome
    at_fault: bool
    collision: bool
    safe: bool
    path_length: float | None
    progress: float | None
    smallest_distance: float | None
    time_to_collision: float | None
    cost_sm1: float | None
    navsim_score: float
    no_collision: float
    drivable: float
    ttc_bound: float
    progress_share: float
    comfort: float
    touched: str
    hardest_braking: float
    emergency_stops: int
    alarms: int
    """The number of perceived instants at which the car's validator raised an alarm."""
    first_plan: Literal["safe", "collision", "unplanned"]
    """The collision check of a single query at the start: of the plan to the intended lane, whether
    the car drives it or begins less ambitiously.  ``unplanned``: there is none, an alarm stops the
    car, or its driver makes no plans."""


class DriveSeconds(TypedDict):
    """How long a drive took."""

    id: str
    seconds: float


def drive_id(setting: str, scenario: str, intention: str) -> str:
    """Names a drive among all others."""
    return f"{setting}/{scenario}/{intention}"
