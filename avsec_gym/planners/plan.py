"""`Plan`: what a motion planner answers, and why it found nothing where it did not."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from avsec_gym.geometry import Floats


class Status(StrEnum):
    """How a search ended."""

    FOUND = "found"
    EXHAUSTED = "exhausted"
    """Nothing is left to try: no sequence of the primitives reaches the goal."""
    LIMIT = "limit"
    """The node or time limit was reached first, or the memory's end."""


class Reason(StrEnum):
    """Why there is no trajectory."""

    START_OCCUPIED = "start_occupied"
    """The ego vehicle overlaps something it believes in before it moves."""
    OFF_ROAD = "off_road"
    """The start, or every place in the goal region, is not on the road."""
    GOAL_OCCUPIED = "goal_occupied"
    """Believed objects leave no room in the goal region for the whole time that the goal allows
    (places are tried every 0.25 m, with five headings)."""
    UNREACHABLE = "unreachable"
    """The goal region has room, but no primitive sequence leads there: at this resolution."""
    LIMIT = "limit"
    """The node or time limit was reached first."""
    MEMORY = "memory"
    """There was no memory for more nodes; a search takes half of the machine's at most."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A planner's answer to one scenario.

    Args:
        status: Status with which the search ended.
        trajectory: States at every time step from the start: x, y of the vehicle's centre (m),
            velocity (m/s), heading, steering angle (rad), shape (T, 5); None where nothing was
            found.
        first_step: Time step of the trajectory's first state.
        start_speed: Speed at which the plan starts, m/s: the nearest that the primitives know to
            the problem's, where they were given.
        cost: Time from start to goal, s; nan where nothing was found.
        expanded: Nodes of which the children were made; the start counts as one.
        seconds: Duration of the search, seconds.
        reason: Why nothing was found; None where something was.
        goal_occupied: Time within the goal's window in which believed objects leave no room in the
            goal region, seconds; nan unless nothing was found.
        lower_bound: Time that any sequence of the primitives needs to the goal at least, seconds,
            where a limit ended a complete A* search; else nan.
        tree: Node states as centres x, y and their parents' numbers, shape (N, 3), where asked for.
    """

    status: Status
    trajectory: Floats | None = None
    first_step: int = 0
    start_speed: float = float("nan")
    cost: float = float("nan")
    expanded: int = 0
    seconds: float = 0.0
    reason: Reason | None = None
    goal_occupied: float = float("nan")
    lower_bound: float = float("nan")
    tree: Floats | None = None

    @property
    def found(self) -> bool:
        """Whether there is a trajectory."""
        return self.trajectory is not None

    @property
    def explanation(self) -> str:
        """One sentence for people."""
        if self.found:
            return f"reached the goal after {self.cost:.1f} s ({self.expanded} nodes)"
        occupied, bound = self.goal_occupied, self.lower_bound
        why = {
            Reason.START_OCCUPIED: "the ego vehicle overlaps an object at the start",
            Reason.OFF_ROAD: "the start or the goal region is not on the road",
            Reason.GOAL_OCCUPIED: f"the goal region is occupied for all its {occupied:.1f} s",
            Reason.UNREACHABLE: "no sequence of motion primitives reaches the goal"
            + (f", occupied for {occupied:.1f} s" if occupied >= 0.05 else ""),
            Reason.LIMIT: f"the limit was reached after {self.expanded} nodes"
            + (f"; no plan takes less than {bound:.1f} s" if bound > 0 else ""),
            Reason.MEMORY: f"memory was at its end after {self.expanded} nodes"
            + (f"; no plan takes less than {bound:.1f} s" if bound > 0 else ""),
        }
        return why[self.reason] if self.reason else self.status.value
