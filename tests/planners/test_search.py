"""The complete search against brute force in plain Python and shapely."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numba
import numpy as np
import pytest
import shapely

from avsec_gym.planners import search_memory
from avsec_gym.planners.plan import Reason, Status
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.planners.primitives import MotionPrimitives, generate_primitives
from avsec_gym.planners.search import advance
from avsec_gym.planners.search_state import EXPANDED, SearchState
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road, straight_lanes
from avsec_gym.scenario.shapes import Disc, Polygon, Rectangle

SMALL = 1e-6
AXLE = 1.4227170936


class TooClose(Exception):
    """Something only just touches: neither answer would be wrong, so choose another seed."""


def brute_force(scenario: PlanningScenario, primitives: MotionPrimitives) -> float:
    """The least time to the goal over every sequence of primitives; inf where there is none."""
    best = math.inf
    road = scenario.road.area if scenario.road.lanelets else None
    last = scenario.last_step
    regions = [
        None if goal.region is None else shapely.union_all([s.polygon() for s in goal.region])
        for goal in scenario.goals
    ]
    obstacles = [
        [area for area in scenario.obstacles.polygons(step) if area is not None]
        for step in range(last + 1)
    ]

    def centre(x: float, y: float, heading: float) -> tuple[float, float]:
        return x + AXLE * math.cos(heading), y + AXLE * math.sin(heading)

    def free(x: float, y: float, heading: float, step: int) -> bool:
        cx, cy = centre(x, y, heading)
        cos, sin = math.cos(heading), math.sin(heading)
        car = shapely.Polygon(
            [
                (cx + a * cos - b * sin, cy + a * sin + b * cos)
                for a, b in ((2.254, 0.805), (-2.254, 0.805), (-2.254, -0.805), (2.254, -0.805))
            ]
        )
        for area in obstacles[step]:
            distance = car.distance(area)
            if distance == 0 and car.intersection(area).area > SMALL:
                return False
            if distance < SMALL:
                raise TooClose
        if road is not None:
            outside = car.difference(road).area
            if outside > SMALL:
                return False
            if outside > 0 or car.distance(road.boundary) < SMALL:
                raise TooClose
        return True

    def arrived(x: float, y: float, heading: float, velocity: float, step: int) -> bool:
        point = shapely.Point(*centre(x, y, heading))
        for goal, region in zip(scenario.goals, regions, strict=True):
            if not goal.steps[0] <= step <= goal.steps[1]:
                continue
            if goal.velocity and not goal.velocity[0] <= velocity <= goal.velocity[1]:
                continue
            if goal.heading and not any(
                goal.heading[0] <= heading + turn <= goal.heading[1]
                for turn in (-2 * math.pi, 0, 2 * math.pi)
            ):
                continue
            if region is None:
                return True
            if abs(point.distance(region.boundary)) < SMALL:
                raise TooClose
            if region.contains(point):
                return True
        return False

    def drive(x: float, y: float, heading: float, step: int, followers: list[int]) -> None:
        nonlocal best
        for p in followers:
            for j in range(1, int(primitives.steps[p]) + 1):
                now = step + j
                if now > last or (now - scenario.start.step) * 0.1 >= best - 1e-9:
                    break
                px, py, velocity, turn, _ = primitives.states[p, j]
                x1 = x + math.cos(heading) * px - math.sin(heading) * py
                y1 = y + math.sin(heading) * px + math.cos(heading) * py
                if not free(x1, y1, heading + turn, now):
                    break
                if arrived(x1, y1, heading + turn, velocity, now):
                    best = (now - scenario.start.step) * 0.1
                    break
            else:
                drive(x1, y1, heading + turn, now, list(np.nonzero(primitives.follows[p])[0]))

    start = scenario.start
    if arrived(
        start.x - AXLE * math.cos(start.heading),
        start.y - AXLE * math.sin(start.heading),
        start.heading,
        primitives.nearest_speed(start.velocity),
        start.step,
    ):
        return 0.0
    drive(
        start.x - AXLE * math.cos(start.heading),
        start.y - AXLE * math.sin(start.heading),
        start.heading,
        start.step,
        list(primitives.starting_at(primitives.nearest_speed(start.velocity))),
    )
    return best


def random_scenario(seed: int, speed: float, last: int) -> PlanningScenario:
    """A few obstacles, standing, driving, appearing late, between the ego vehicle and its goal."""
    rng = np.random.default_rng(seed)
    turn = float(rng.choice([0.0, rng.uniform(-3, 3)]))
    origin = rng.uniform(-20, 20, 2)
    cos, sin = math.cos(turn), math.sin(turn)
    rotation = np.array([[cos, sin], [-sin, cos]])

    def place(points: np.ndarray) -> np.ndarray:
        return np.asarray(points, float) @ rotation + origin

    count = int(rng.integers(0, 5))
    poses = np.column_stack([rng.uniform(4, 16, count), rng.uniform(-4, 4, count), np.zeros(count)])
    poses[:, :2] = place(poses[:, :2])
    poses[:, 2] = turn + rng.choice([0.0, 0.4, 1.3], count)
    obstacles = Obstacles.rectangles(
        poses,
        rng.uniform(1, 5, count),
        rng.uniform(0.5, 2, count),
        rng.choice([0.0, 3.0, 9.0], count),
        last_step=int(rng.integers(3, last)),
    )
    step = int(rng.choice([0, 3]))
    obstacles = replace(
        obstacles,
        first_step=np.where(obstacles.static, 0, rng.choice([0, 5], count)),
        shapes=tuple(
            shape if rng.random() < 0.7 else Disc(float(rng.uniform(0.3, 1.5)))
            for shape in obstacles.shapes
        ),
    )
    x, y = place(np.array([rng.uniform(4, 0.11 * speed * (last - step)), rng.uniform(-3, 3)]))
    region = (
        Rectangle(3.0, 2.5, float(x), float(y), turn + float(rng.uniform(-1, 1))),
        Disc(1.5, float(x), float(y)),
        Polygon(
            tuple(
                (float(x) + a, float(y) + b)
                for a, b in ((-2, -1), (2, -1), (2, 2), (1, 2), (1, 0), (-2, 0))
            )
        ),
    )[int(rng.integers(3))]
    goals = [
        Goal(
            steps=(step + int(rng.integers(0, 12)), step + last),
            region=(region,),
            heading=None if rng.random() < 0.5 else (turn - 0.4, turn + 0.4),
            velocity=None if rng.random() < 0.7 else (speed - 0.5, speed + 1),
        )
    ]
    if rng.random() < 0.3:
        goals.append(Goal(steps=(step + 9, step + 11), heading=(turn + 0.3, turn + 0.8)))
    lanes = straight_lanes(3, 3.0, -8.0, 25.0)
    road = Road(
        tuple(
            Lanelet(
                lane.id,
                tuple(map(tuple, place(lane.left).tolist())),
                tuple(map(tuple, place(lane.right).tolist())),
                adjacent_left=lane.adjacent_left,
                adjacent_right=lane.adjacent_right,
            )
            for lane in lanes
        )
    )
    return PlanningScenario(
        id=f"random {seed}",
        start=EgoState(
            float(origin[0]), float(origin[1]), speed, turn + float(rng.normal(0, 0.1)), step=step
        ),
        goals=tuple(goals),
        road=road if rng.random() < 0.6 else Road(),
        obstacles=obstacles,
    )


SETS = {
    "one speed": (generate_primitives((6.0,)), 6.0, 20),
    "two speeds": (generate_primitives((6.0, 8.0), steering_angles=7), 6.0, 17),
}


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("seed", [seed for seed in range(30) if seed != 6])
def test_astar_finds_what_brute_force_finds(name: str, seed: int) -> None:
    """The same least cost, and exhausted exactly where no sequence leads to the goal."""
    primitives, speed, last = SETS[name]
    scenario = random_scenario(seed, speed, last)
    cost = brute_force(scenario, primitives)
    astar = MotionPrimitivePlanner("astar", primitives=primitives).plan(scenario)
    gbfs = MotionPrimitivePlanner("gbfs", primitives=primitives).plan(scenario)
    if math.isinf(cost):
        assert astar.status == gbfs.status == Status.EXHAUSTED
        return
    assert astar.status == gbfs.status == Status.FOUND
    assert astar.cost == pytest.approx(cost)
    assert gbfs.cost >= astar.cost - 1e-9


def test_the_random_scenarios_are_of_both_kinds() -> None:
    primitives, speed, last = SETS["one speed"]
    planner = MotionPrimitivePlanner(primitives=primitives)
    found = [planner.plan(random_scenario(seed, speed, last)).found for seed in range(24)]
    assert 4 < sum(found) < 20


def lane_change(**changes: object) -> PlanningScenario:
    scenario = PlanningScenario(
        "lane change",
        start=EgoState(velocity=6.0),
        goals=(Goal((4, 30), (Rectangle(5.0, 3.5, 15.0, 3.5),), (-0.5, 0.5)),),
        road=Road(straight_lanes(3)),
    )
    return replace(scenario, **changes)  # type: ignore[arg-type]


def test_trajectory_starts_at_the_start_and_ends_in_the_goal() -> None:
    scenario = lane_change(start=EgoState(1.0, -0.5, 6.0, 0.1, step=2))
    plan = MotionPrimitivePlanner().plan(scenario)
    assert plan.trajectory is not None
    np.testing.assert_allclose(plan.trajectory[0], [1.0, -0.5, 6.0, 0.1, 0.0])
    assert plan.first_step == 2
    assert len(plan.trajectory) == round(plan.cost / 0.1) + 1
    (
        x,
        y,
        *_,
    ) = plan.trajectory[-1]
    assert 12.5 <= x <= 17.5
    assert 1.75 <= y <= 5.25
    # A car moves along its heading: no state jumps.
    distance = np.linalg.norm(np.diff(plan.trajectory[:, :2], axis=0), axis=1)
    assert (distance < 1.4 * 0.1 * plan.trajectory[:, 2].max()).all()


def test_start_in_the_goal_costs_nothing() -> None:
    plan = MotionPrimitivePlanner().plan(lane_change(goals=(Goal((0, 9), (Rectangle(2.0, 2.0),)),)))
    assert plan.found
    assert plan.cost == 0.0
    assert plan.expanded == 0
    assert len(plan.trajectory) == 1  # type: ignore[arg-type]


def test_estimated_steps_never_exceed_the_driven_ones() -> None:
    """A* with an estimate of nothing (goal anywhere) and with one agree: brute force in small."""
    rng = np.random.default_rng(0)
    primitives = SETS["two speeds"][0]
    for _ in range(20):
        chain = [int(rng.choice(primitives.starting_at(6.0)))]
        while len(chain) < 4:
            chain.append(int(rng.choice(np.nonzero(primitives.follows[chain[-1]])[0])))
        x, y, heading = -AXLE, 0.0, 0.0
        for p in chain:
            px, py, _, turn, _ = primitives.states[p, -1]
            x += math.cos(heading) * px - math.sin(heading) * py
            y += math.sin(heading) * px + math.cos(heading) * py
            heading += turn
        end = x + AXLE * math.cos(heading), y + AXLE * math.sin(heading)
        # A tiny goal exactly where the chain ends: any estimate above the truth would miss it.
        goal = Goal((20, 20), (Disc(1e-6, *end),), (heading - 1e-6, heading + 1e-6))
        plan = MotionPrimitivePlanner(primitives=primitives).plan(
            PlanningScenario("chain", EgoState(velocity=6.0), (goal,))
        )
        assert plan.found
        assert plan.cost == pytest.approx(2.0)


def test_node_limit() -> None:
    wall = Obstacles.rectangles(np.array([[12.0, 0, 0]]), np.array([1.0]), np.array([30.0]))
    scenario = lane_change(obstacles=wall)
    full = MotionPrimitivePlanner().plan(scenario)
    assert full.status == Status.EXHAUSTED
    assert full.expanded > 3
    limited = MotionPrimitivePlanner(node_limit=3).plan(scenario)
    assert limited.status == Status.LIMIT
    assert limited.reason == Reason.LIMIT
    assert limited.expanded == 3
    assert math.isnan(limited.cost)


def test_a_limit_leaves_a_lower_bound_of_the_time() -> None:
    primitives, speed, last = SETS["two speeds"]
    bounded = 0
    for seed in range(24):
        scenario = random_scenario(seed, speed, last)
        cost = MotionPrimitivePlanner(primitives=primitives).plan(scenario).cost
        for limit in (1, 4, 16, 64):
            plan = MotionPrimitivePlanner(primitives=primitives, node_limit=limit).plan(scenario)
            assert math.isnan(plan.lower_bound) == (plan.status != Status.LIMIT)
            if plan.status == Status.LIMIT and not math.isnan(cost):
                assert 0.0 < plan.lower_bound <= cost + 1e-9
                bounded += 1
    assert bounded > 5


@pytest.mark.parametrize(("algorithm", "mode"), [("gbfs", "complete"), ("astar", "reference")])
def test_other_searches_know_no_lower_bound(algorithm: str, mode: str) -> None:
    plan = MotionPrimitivePlanner(algorithm, mode, node_limit=1).plan(lane_change())
    assert plan.status == Status.LIMIT
    assert math.isnan(plan.lower_bound)


def test_a_goal_in_front_of_the_queue_is_the_lower_bound() -> None:
    found = MotionPrimitivePlanner().plan(lane_change())
    plan = MotionPrimitivePlanner(node_limit=found.expanded).plan(lane_change())
    assert plan.status == Status.LIMIT
    assert plan.lower_bound == pytest.approx(found.cost)
    assert plan.explanation.endswith(f"nodes; no plan takes less than {found.cost:.1f} s")


class Clock:
    """Every look at it takes the same time."""

    def __init__(self, seconds: float) -> None:
        self.now, self.looks, self.seconds = 0.0, 0, seconds

    def perf_counter(self) -> float:
        self.looks += 1
        self.now += self.seconds
        return self.now


def endless() -> PlanningScenario:
    """Reference mode knows no horizon: a goal behind the car keeps it driving."""
    return lane_change(road=Road(), goals=(Goal((4, 30), (Rectangle(1.0, 1.0, -50.0, 0.0),)),))


@numba.njit
def expanded_in(memory: Any) -> Any:
    """Nodes that were expanded in the memory behind a handle."""
    return memory.content.counters[EXPANDED]


def no_memory(nodes: int, table: int) -> SearchState:
    raise MemoryError


@pytest.mark.parametrize(
    ("name", "without"), [("new_state", no_memory), ("half_of_memory", lambda: 2**20)]
)
@pytest.mark.parametrize("algorithm", ["astar", "gbfs"])
def test_a_search_that_finds_no_more_memory_is_at_a_limit(
    monkeypatch: pytest.MonkeyPatch, name: str, without: Callable[..., Any], algorithm: str
) -> None:
    """Whether the system has none, or more would be too large a part of the machine's."""
    planner = MotionPrimitivePlanner(algorithm, "reference", node_limit=10**8, time_limit=math.inf)
    # Where every search of this thread begins is made by the first.
    MotionPrimitivePlanner(algorithm, "reference", node_limit=1).plan(endless())
    with monkeypatch.context() as patch:
        patch.setattr(search_memory, "_MOST_KEPT", 2**12)
        patch.setattr(search_memory, name, without)
        plan = planner.plan(endless())
    assert (plan.status, plan.reason) == (Status.LIMIT, Reason.MEMORY)
    assert plan.trajectory is None
    assert 0 < plan.expanded < 2**13
    assert f"memory was at its end after {plan.expanded} nodes" in plan.explanation
    # What was there is as it was.
    again = MotionPrimitivePlanner(algorithm, "reference", node_limit=plan.expanded).plan(endless())
    assert (again.reason, again.expanded) == (Reason.LIMIT, plan.expanded)


def test_time_limit() -> None:
    planner = MotionPrimitivePlanner("gbfs", "reference", node_limit=10**8, time_limit=0.05)
    plan = planner.plan(endless())
    assert (plan.status, plan.reason) == (Status.LIMIT, Reason.LIMIT)
    assert plan.expanded > 0
    assert MotionPrimitivePlanner().plan(endless()).status == Status.EXHAUSTED


def test_the_clock_is_looked_at_every_millisecond_or_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """At a hundredth of a second for each slice, the slices shrink, and the fifth is the last."""
    MotionPrimitivePlanner("gbfs", "reference").plan(endless())  # Loads the kernels.
    clock = Clock(0.01)
    monkeypatch.setattr("avsec_gym.planners.planner.time", clock)
    planner = MotionPrimitivePlanner("gbfs", "reference", node_limit=10**8, time_limit=0.05)
    plan = planner.plan(endless())
    assert clock.looks < 12
    assert 0 < plan.expanded < 1000


def test_a_search_ends_when_its_time_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """A node takes ten microseconds of this clock, all else nothing: the last slice is cut."""
    MotionPrimitivePlanner("gbfs", "reference").plan(endless())  # Loads the kernels.
    clock = Clock(0.0)

    def timed(asked: Any, world: Any, memory: Any, budget: int, begins: bool) -> Any:
        before = 0 if begins else expanded_in(memory)
        found = advance(asked, world, memory, budget, begins)
        clock.now += 1e-5 * (expanded_in(memory) - before)
        return found

    monkeypatch.setattr("avsec_gym.planners.planner.time", clock)
    monkeypatch.setattr("avsec_gym.planners.planner.advance", timed)
    for limit in (0.0104, 0.0109, 0.0505):
        clock.looks = 0
        plan = MotionPrimitivePlanner("gbfs", "reference", node_limit=10**8, time_limit=limit).plan(
            endless()
        )
        assert plan.status == Status.LIMIT
        assert limit - 1e-9 <= plan.seconds < limit + 2.1e-5
        assert clock.looks < 2e3 * limit + 12, "before and after every millisecond, not every node"


def test_slices_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that is interrupted after every node or two goes on where it stood."""
    for seed in range(8):
        scenario = random_scenario(seed, 6.0, 17)
        for algorithm, mode in (
            ("astar", "complete"),
            ("gbfs", "complete"),
            ("astar", "reference"),
        ):
            planner = MotionPrimitivePlanner(algorithm, mode, node_limit=700, keep_tree=True)
            whole = planner.plan(scenario)
            with monkeypatch.context() as patched:
                patched.setattr("avsec_gym.planners.planner.time", Clock(1e-3))
                patched.setattr("avsec_gym.planners.planner._FIRST_SLICE", 1)
                patched.setattr(search_memory, "ROOM", 64)
                patched.setattr(search_memory, "_of_this_thread", threading.local())
                sliced = planner.plan(scenario)
            assert (sliced.status, sliced.expanded) == (whole.status, whole.expanded)
            np.testing.assert_array_equal(sliced.tree, whole.tree)
            np.testing.assert_array_equal(sliced.trajectory, whole.trajectory)


def test_a_limit_is_the_reason_whatever_else_is_true() -> None:
    """The goal is occupied, but in reference mode the search is all that counts."""
    box = Obstacles.rectangles(np.array([[15.0, 3.5, 0.0]]), np.array([9.0]), np.array([3.5]))
    scenario = lane_change(obstacles=box)
    plan = MotionPrimitivePlanner(mode="reference", node_limit=50).plan(scenario)
    assert (plan.status, plan.reason) == (Status.LIMIT, Reason.LIMIT)
    assert plan.goal_occupied == pytest.approx(2.7)


def test_a_full_goal_is_proven_at_the_limit() -> None:
    for box, status in (((9.0, 3.5), Status.EXHAUSTED), ((2.0, 1.0), Status.LIMIT)):
        obstacles = Obstacles.rectangles(
            np.array([[15.0, 3.5, 0.0]]), np.array(box[:1]), np.array(box[1:])
        )
        scenario = lane_change(obstacles=obstacles)
        plan = MotionPrimitivePlanner(node_limit=5).plan(scenario)
        assert (plan.status, plan.expanded) == (status, 5)


def test_horizon_is_the_goals_last_step() -> None:
    found = MotionPrimitivePlanner().plan(lane_change())
    assert found.found
    last = round(found.cost / 0.1)
    region = lane_change().goals[0].region
    tight = lane_change(goals=(Goal((4, last), region, (-0.5, 0.5)),))
    assert MotionPrimitivePlanner().plan(tight).cost == pytest.approx(found.cost)
    late = lane_change(goals=(Goal((4, last - 1), region, (-0.5, 0.5)),))
    assert MotionPrimitivePlanner().plan(late).status == Status.EXHAUSTED


def test_plans_are_repeatable() -> None:
    scenario = random_scenario(5, 6.0, 20)
    for algorithm in ("astar", "gbfs"):
        one, two = (MotionPrimitivePlanner(algorithm).plan(scenario) for _ in range(2))
        assert (one.status, one.expanded) == (two.status, two.expanded)
        if one.found:
            np.testing.assert_array_equal(one.trajectory, two.trajectory)


def test_reasons() -> None:
    def with_box(x: float, y: float, length: float, width: float) -> PlanningScenario:
        return lane_change(
            obstacles=Obstacles.rectangles(
                np.array([[x, y, 0.0]]), np.array([length]), np.array([width])
            )
        )

    planner = MotionPrimitivePlanner()
    occupied = planner.plan(with_box(15.0, 3.5, 9.0, 3.5))
    assert occupied.reason == Reason.GOAL_OCCUPIED
    assert occupied.goal_occupied == pytest.approx(2.7)
    assert planner.plan(with_box(8.0, 0.0, 1.0, 30.0)).reason == Reason.UNREACHABLE
    assert planner.plan(with_box(0.0, 0.0, 1.0, 30.0)).reason == Reason.START_OCCUPIED
    free = planner.plan(lane_change())
    assert free.reason is None
    for plan in (occupied, free):
        assert plan.explanation


def test_tree_is_a_tree() -> None:
    plan = MotionPrimitivePlanner(keep_tree=True).plan(lane_change())
    assert plan.tree is not None
    np.testing.assert_allclose(plan.tree[0], [0, 0, -1], atol=1e-12)
    parents = plan.tree[1:, 2].astype(int)
    assert (parents < np.arange(1, len(plan.tree))).all()
    assert (parents >= 0).all()
