"""A certificate that no plan led past a collision any more, by a complete search.

From the state that a car has reached, every sequence of the driver's own motion primitives is
searched against what is really there and will really come.  Where none stays on the road and clear
of everything until a second after the collision, no plan of this resolution avoided it.

`unavoidable` proves more of fewer cases: it asks what any car could do from the start on.

For users of the library (docs/closed_loop.md); of ours, studies/driving_safety asks it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from avsec_gym.closed_loop.made_primitives import primitives_from, rounded_start
from avsec_gym.closed_loop.tracks import STEP, Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.planners.plan import Status
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.shapes import Rectangle

_AFTER = 1.0
"""Seconds after the collision until which a plan has to lead: what is only put off does not
count."""
_LAST_STEPS = 5
"""Steps of a primitive: a plan may end anywhere in its last one."""
_NODES = 3_000_000
"""Nodes of one search; each takes about two microseconds."""
_SECONDS = 60.0


@dataclass(frozen=True)
class NoWayOut:
    """The time from which on no plan led past a collision.

    Args:
        since: Seconds after the start: the earliest of the replannings from which on, up to the
            last before the collision, a complete search found none.
        replannings: How many these are.
    """

    since: float
    replannings: int


def no_way_out(
    scene: TrafficScene, replannings: Iterable[tuple[float, EgoState]], collision: float
) -> NoWayOut | None:
    """The replanning from which on no plan led past a collision; None: the last one did, or may.

    Args:
        scene: The scene; its actors play their tracks.
        replannings: When the car planned, seconds after the start, and the states that it had
            really reached; in the order of time.
        collision: When it collided, seconds after the start.
    """
    found = None
    for time, state in reversed([each for each in replannings if each[0] < collision]):
        if not has_no_plan(scene, state, time, collision + _AFTER):
            break
        found = NoWayOut(time, 1 if found is None else found.replannings + 1)
    return found


def has_no_plan(scene: TrafficScene, state: EgoState, time: float, until: float) -> bool:
    """Whether a complete search proves that no plan leads on until a time.

    Args:
        scene: The scene; its actors play their tracks.
        state: The state that the car has really reached.
        time: Seconds after the start.
        until: Seconds after the start until which a plan has to stay on the road and touch nothing.
    """
    steps = math.ceil((until - time) / STEP - 1e-9)
    primitives = primitives_from(state.velocity, state.steering_angle, scene.cruise)
    problem = PlanningScenario(
        id=scene.id,
        start=rounded_start(state, primitives),
        goals=(Goal(steps=(steps, steps + _LAST_STEPS)),),
        road=scene.road,
        obstacles=obstacles_to_come(scene.tracks, scene.sets_off + time, steps + _LAST_STEPS),
        dt=STEP,
        road_type=scene.road_type,
    )
    planner = MotionPrimitivePlanner(primitives=primitives, node_limit=_NODES, time_limit=_SECONDS)
    return planner.plan(problem, explain=False).status == Status.EXHAUSTED


def obstacles_to_come(tracks: Tracks, time: float, steps: int) -> Obstacles:
    """Recorded actors as obstacles, from a time on, those that stay until the end.

    Planners keep an obstacle's last state for ever: what leaves before is left out, so that nothing
    is in the way that is not there.

    Args:
        tracks: The actors.
        time: Seconds after the tracks' start.
        steps: Time steps after the first, a tenth of a second each.
    """
    times = time + STEP * np.arange(steps + 1)
    poses, speeds = (each.swapaxes(0, 1) for each in tracks.states(times))
    first = np.maximum(np.ceil(tracks.first - times[0] / STEP - 1e-6).astype(np.int64), 0)
    stays = (tracks.last >= times[-1] / STEP - 1e-6) & (first <= steps)
    kept = np.flatnonzero(stays & (tracks.dimensions > 0).all(axis=1))
    first = first[kept]
    # Rows begin with the first state that is known, and repeat the last one.
    columns = np.minimum(first[:, None] + np.arange(steps + 1), steps)
    rows = kept[:, None]
    return Obstacles(
        ids=1000 + np.arange(len(kept)),
        categories=np.full(len(kept), "car"),
        shapes=tuple(Rectangle(*size) for size in tracks.dimensions[kept][:, [2, 1]].tolist()),
        poses=poses[rows, columns],
        speeds=speeds[rows, columns],
        steps=steps + 1 - first,
        first_step=first,
        static=np.zeros(len(kept), bool),
    )
