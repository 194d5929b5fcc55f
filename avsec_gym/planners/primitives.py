"""Motion primitives: short drivable pieces that a planner strings together.

A primitive starts at the origin with heading 0, at one point of a grid of speeds and steering
angles, and ends, at constant acceleration and steering rate, at another.  One primitive may follow
another where speed and steering angle meet.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.planners.vehicle import BMW_320I, Vehicle, is_feasible, simulate
from avsec_gym.scenario.bounds import DURATION
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.planning_scenario import PlanningScenario

_MEETING_TOLERANCE = 0.01
"""Speeds (m/s) and steering angles (rad) that differ by less are the same (commonroad-search)."""
_ROUGHNESS = 0.01
"""Share of a way by which the circle around it is widened."""
_WIDE_SPEED, _WIDE_STEP = 20.0, 2.0
"""Highest and spacing of the speeds where no road type gives them, m/s."""


class PrimitiveArrays(NamedTuple):
    """What the search kernel reads."""

    states: Floats
    """Rear-axle x, y, velocity, heading, steering angle, cosine and sine of the heading: shape
    (P, T + 1, 7)."""
    sweep: Floats
    """A circle around all places of the vehicle's centre on the way: x, y, radius; then the least
    and the greatest velocity after the start; shape (P, 5)."""
    steps: NDArray[np.int64]
    """Number of states after the first, shape (P,)."""
    successors: NDArray[np.int64]
    """Primitives that may follow, all lists joined."""
    first_successor: NDArray[np.int64]
    """Where each primitive's list begins, shape (P + 1,)."""
    end_class: NDArray[np.int64]
    """Primitives with equal numbers are followed by the same ones, shape (P,)."""


@dataclass(frozen=True, eq=False)
class MotionPrimitives:
    """A set of motion primitives of one vehicle.

    Args:
        states: Rear-axle x, y (m), velocity (m/s), heading, steering angle (rad),
            shape (P, T + 1, 5); rows after a shorter primitive's end repeat its last state.
        steps: Number of states after the first, shape (P,).
        vehicle: The vehicle whose they are.
        dt: Length of a time step, seconds.
        name: Name for messages and reports.
        grid: A set whose primitives stand first in this one.  The others lead from off its grid
            onto it: each ends as some of its primitives do, and follows none.  What the search
            needs is then laid out for the grid once, and not for every start.
    """

    states: Floats
    steps: NDArray[np.int64]
    vehicle: Vehicle = BMW_320I
    dt: float = 0.1
    name: str = "primitives"
    grid: MotionPrimitives | None = None

    def __post_init__(self) -> None:
        if not np.isfinite(self.states).all():
            raise ConfigurationError(f"{self.name}: a state holds a value that is not finite")
        DURATION.check(self.dt, f"{self.name}: the duration of a time step")

    def __len__(self) -> int:
        return len(self.states)

    @property
    def ends(self) -> Floats:
        """The last state of each, shape (P, 5)."""
        return self.states[np.arange(len(self)), self.steps]

    @cached_property
    def follows(self) -> NDArray[np.bool_]:
        """Whether primitive j may follow primitive i, shape (P, P)."""
        if self.grid is not None:
            onto = np.vstack([self.grid.follows, self.grid.follows[self._twins]])
            return np.pad(onto, ((0, 0), (0, len(self._twins))))
        # Few pairs of speed and angle are shared by many primitives.
        ends, end_of = _distinct(self.ends[:, [2, 4]])
        starts, start_of = _distinct(self.states[:, 0][:, [2, 4]])
        meets = np.all(np.abs(ends[:, None] - starts) < _MEETING_TOLERANCE, axis=-1)
        return np.asarray(np.asarray(meets)[np.ix_(end_of, start_of)])

    @cached_property
    def endless(self) -> NDArray[np.bool_]:
        """Whether some chain of primitives can go on for ever after each, shape (P,)."""
        alive = np.ones(len(self), bool)
        while True:
            still_alive = alive & (self.follows & alive).any(axis=1)
            if (still_alive == alive).all():
                return alive
            alive = still_alive

    @cached_property
    def arrays(self) -> PrimitiveArrays:
        """The primitives laid out for the search kernel."""
        if self.grid is not None:
            return self._onto_grid(self.grid.arrays)
        counts = self.follows.sum(axis=1)
        # Rows as strings of bits: numpy compares columns one by one, which takes a hundred times.
        rows = np.packbits(self.follows, axis=1)
        bits = np.ascontiguousarray(rows).view(np.dtype((np.void, rows.shape[1]))).ravel()
        _, end_class = np.unique(bits, return_inverse=True)
        cos, sin = np.cos(self.states[..., 3]), np.sin(self.states[..., 3])
        return PrimitiveArrays(
            states=np.concatenate([self.states, cos[..., None], sin[..., None]], axis=-1),
            sweep=self._sweep(self.states, cos, sin),
            steps=np.ascontiguousarray(self.steps),
            successors=np.nonzero(self.follows)[1].astype(np.int64),
            first_successor=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            end_class=end_class.reshape(-1).astype(np.int64),
        )

    @cached_property
    def _twins(self) -> NDArray[np.int64]:
        """For each primitive that leads onto the grid, one of the grid that ends alike."""
        assert self.grid is not None
        known = len(self.grid)
        alike = {tuple(end): i for i, end in enumerate(self.ends[:known, [2, 4]].tolist())}
        ends = [tuple(end) for end in self.ends[known:, [2, 4]].tolist()]
        if not alike.keys() >= set(ends):
            raise ConfigurationError(f"{self.name}: a primitive does not lead onto the grid")
        return np.array([alike[end] for end in ends], np.int64)

    def _onto_grid(self, grid: PrimitiveArrays) -> PrimitiveArrays:
        """The grid's arrays, with those that lead onto it at the end."""
        twins, own = self._twins, self.states[len(self.grid or ()) :]
        cos, sin = np.cos(own[..., 3]), np.sin(own[..., 3])
        after = [
            grid.successors[grid.first_successor[i] : grid.first_successor[i + 1]] for i in twins
        ]
        ends = len(grid.successors) + np.cumsum([len(each) for each in after], dtype=np.int64)
        states = np.concatenate([own, cos[..., None], sin[..., None]], axis=-1)
        return PrimitiveArrays(
            states=np.concatenate([grid.states, states]),
            sweep=np.concatenate([grid.sweep, self._sweep(own, cos, sin)]),
            steps=np.ascontiguousarray(self.steps),
            successors=np.concatenate([grid.successors, *after]),
            first_successor=np.concatenate([grid.first_successor, ends]),
            end_class=np.concatenate([grid.end_class, grid.end_class[twins]]),
        )

    def _sweep(self, states: Floats, cos: Floats, sin: Floats) -> Floats:
        offset = self.vehicle.rear_axle
        x, y = states[..., 0] + offset * cos, states[..., 1] + offset * sin
        middle_x = 0.5 * (x.min(axis=1) + x.max(axis=1))
        middle_y = 0.5 * (y.min(axis=1) + y.max(axis=1))
        radius = np.hypot(x - middle_x[:, None], y - middle_y[:, None]).max(axis=1)
        # Reference mode turns small angles roughly: the length of a way by up to 0.13 %.
        radius += _ROUGHNESS * np.hypot(x, y).max(axis=1)
        velocity = states[:, 1:, 2]
        return np.column_stack(
            [middle_x, middle_y, radius, velocity.min(axis=1), velocity.max(axis=1)]
        )

    def nearest_speed(self, velocity: float, *, endless_only: bool = False) -> float:
        """The start speed in the set that is nearest to a velocity; the first among equals."""
        speeds = self.states[self.endless if endless_only else slice(None), 0, 2]
        if not len(speeds):
            raise ConfigurationError(f"{self.name}: no primitive can be continued")
        return float(speeds[np.argmin(np.abs(speeds - velocity))])

    def starting_at(
        self, velocity: float, steering_angle: float = 0.0, *, endless_only: bool = False
    ) -> NDArray[np.int64]:
        """Primitives that begin at a speed and steering angle, in the set's order."""
        starts = self.states[:, 0]
        fits = (np.abs(starts[:, 2] - velocity) < _MEETING_TOLERANCE) & (
            np.abs(starts[:, 4] - steering_angle) < _MEETING_TOLERANCE
        )
        return np.nonzero(fits & self.endless if endless_only else fits)[0]


def _distinct(rows: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Distinct rows, and which of them each row is."""
    distinct, inverse = np.unique(rows, axis=0, return_inverse=True)
    return distinct, inverse.reshape(-1)


def generate_primitives(
    speeds: tuple[float, ...],
    *,
    vehicle: Vehicle = BMW_320I,
    steering_angles: int = 13,
    duration: float = 0.5,
    dt: float = 0.1,
    extra_start_speeds: tuple[float, ...] = (),
) -> MotionPrimitives:
    """Every feasible primitive between the points of a grid.

    Args:
        speeds: Grid of speeds, m/s.
        vehicle: The vehicle, whose limits hold.
        steering_angles: Number of angles from the vehicle's one lock to the other; odd.
        duration: Duration of a primitive, seconds.
        dt: Length of a time step, seconds.
        extra_start_speeds: Speeds off the grid from which primitives lead onto it, wheels straight.

    Returns:
        The set, sorted by start speed, start angle, end speed, end angle.

    Raises:
        ConfigurationError: The grid makes no primitive.

    Example:
        >>> street = generate_primitives((6.0,))
        >>> len(street), street.states.shape[1]
        (19, 6)
    """
    if steering_angles < 1 or steering_angles % 2 == 0:
        raise ConfigurationError(f"steering_angles is an odd number, got {steering_angles}")
    limit = vehicle.max_steering_angle
    angles = np.linspace(-limit, limit, steering_angles) if steering_angles > 1 else np.zeros(1)
    angles[steering_angles // 2] = 0.0
    grid = [(v, s) for v in sorted(set(speeds)) for s in angles]
    starts = np.array(grid + [(v, 0.0) for v in sorted(set(extra_start_speeds) - set(speeds))])
    steps = round(duration / dt)
    start, end = (
        array.reshape(-1, 2)
        for array in np.broadcast_arrays(starts[:, None, :], np.array(grid)[None, :, :])
    )
    acceleration = (end[:, 0] - start[:, 0]) / (steps * dt)
    steering_rate = (end[:, 1] - start[:, 1]) / (steps * dt)
    state = np.zeros((len(start), 5))
    state[:, 2], state[:, 4] = start[:, 0], start[:, 1]
    states = simulate(vehicle, state, acceleration, steering_rate, steps, dt)
    # Land on the grid exactly, so that primitives meet without drift.
    states[:, -1, 2], states[:, -1, 4] = end[:, 0], end[:, 1]
    states = states[is_feasible(vehicle, states, acceleration, steering_rate)]
    if not len(states):
        raise ConfigurationError(f"no motion primitive is feasible between the speeds {speeds}")
    return MotionPrimitives(
        states=states,
        steps=np.full(len(states), steps),
        vehicle=vehicle,
        dt=dt,
        name=f"{vehicle.name} {'/'.join(f'{v:g}' for v in sorted(set(speeds)))} m/s",
    )


@lru_cache(maxsize=64)
def standard_primitives(
    speeds: tuple[float, ...], extra_start_speeds: tuple[float, ...] = ()
) -> MotionPrimitives:
    """`generate_primitives` with its defaults, made once in a process."""
    return generate_primitives(speeds, extra_start_speeds=extra_start_speeds)


def suitable_primitives(scenario: PlanningScenario) -> MotionPrimitives:
    """The generated set for a scenario's road type, or one of all speeds where it has none.

    Where the start speed lies off the grid, primitives that lead onto it are added.
    """
    start = scenario.start.velocity
    if scenario.road_type is not None:
        grid = driving_constraints(scenario.road_type).primitive_speeds
    else:
        wanted = [start, *(goal.velocity[0] for goal in scenario.goals if goal.velocity)]
        fastest = min(BMW_320I.max_velocity, max(_WIDE_SPEED, *wanted))
        grid = tuple(np.arange(0.0, fastest + _WIDE_STEP, _WIDE_STEP).tolist())
    return standard_primitives(grid, () if start in grid else (start,))
