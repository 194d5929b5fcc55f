"""Planned trajectories before an independent judge: commonroad-drivability-checker."""

from __future__ import annotations

import os
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import PlanningError
from avsec_gym.geometry import ego_to_camera
from avsec_gym.planners.plan import Plan
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.planners.primitives import generate_primitives
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.commonroad import to_commonroad
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.road import Lanelet, Road
from avsec_gym.scenario.shapes import Rectangle


def cars(rng: np.random.Generator, count: int) -> Boxes3D:
    poses = np.column_stack(
        [rng.uniform(7, 30, count), rng.uniform(-9, 9, count), rng.normal(0, 0.1, count)]
    )
    location, rotation_y = ego_to_camera(poses, 1.65)
    return Boxes3D(
        location,
        np.tile([1.5, 1.7, 4.1], (count, 1)),
        rotation_y,
        np.ones(count),
        np.full(count, "Car"),
    )


def built(seed: int) -> PlanningScenario:
    """As from a KITTI frame: street or highway, some cars, half of them driving."""
    rng = np.random.default_rng(seed)
    road_type = list(RoadType)[seed % 2]
    boxes = cars(rng, 3)
    speed = None if seed % 3 else (6.7 if road_type == RoadType.STREET else 12.2)
    return build_planning_scenario(
        boxes,
        road_type=road_type,
        intention=list(Intention)[seed % 3],
        speeds=np.where(rng.random(3) < 0.5, 7.0, 0.0),
        start_speed=speed,
        id=f"built {seed}",
    )


def curved(radius: float) -> PlanningScenario:
    """A lane of 3.2 m along an arc; the goal lies 18 m down the road."""
    arc = np.linspace(-8, 40, 40) / radius

    def bound(offset: float) -> tuple[tuple[float, float], ...]:
        r = radius - offset
        return tuple((float(r * np.sin(a)), float(radius - r * np.cos(a))) for a in arc)

    angle = 18 / radius
    goal = Rectangle(
        4.0, 3.0, float(radius * np.sin(angle)), float(radius - radius * np.cos(angle)), angle
    )
    return PlanningScenario(
        f"curve of {radius} m",
        EgoState(velocity=6.0),
        (Goal((4, 40), (goal,), (angle - 0.4, angle + 0.4)),),
        Road((Lanelet(1, bound(1.6), bound(-1.6)),)),
        road_type=RoadType.STREET,
    )


SCENARIOS = [built(seed) for seed in range(20) if seed != 1] + [
    curved(r) for r in (45.0, -45.0, 90.0)
]


def judge(scenario: PlanningScenario, plan: Plan) -> dict[str, bool]:
    """The checker's results for a plan, check by check (without the road boundary)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        checker = pytest.importorskip("commonroad_dc.feasibility.solution_checker")
        from commonroad.common.solution import (
            CostFunction,
            PlanningProblemSolution,
            Solution,
            VehicleModel,
            VehicleType,
        )
        from commonroad.scenario.state import KSState
        from commonroad.scenario.trajectory import Trajectory

        document, problems = to_commonroad(scenario)
        assert plan.trajectory is not None
        states: list[Any] = [
            KSState(
                position=np.array([x, y]),
                velocity=float(v),
                orientation=float(heading),
                steering_angle=float(steering),
                time_step=plan.first_step + t,
            )
            for t, (x, y, v, heading, steering) in enumerate(plan.trajectory)
        ]
        number = next(iter(problems.planning_problem_dict))
        solution = Solution(
            document.scenario_id,
            [
                PlanningProblemSolution(
                    planning_problem_id=number,
                    vehicle_model=VehicleModel.KS,
                    vehicle_type=VehicleType.BMW_320i,
                    cost_function=CostFunction.SM1,
                    trajectory=Trajectory(plan.first_step, states),
                )
            ],
        )
        return {
            "start": checker.starts_at_correct_state(solution, problems),
            "goal": checker.goal_reached(document, problems, solution),
            "free": not checker.obstacle_collision(document, problems, solution),
            "feasible": checker.solution_feasible(solution, document.dt, problems)[number][0],
        }


@pytest.mark.parametrize("number", range(len(SCENARIOS)), ids=lambda n: SCENARIOS[n].id)
def test_the_judge_accepts_the_trajectory(number: int) -> None:
    scenario = SCENARIOS[number]
    plan = MotionPrimitivePlanner(("astar", "gbfs")[number % 2]).plan(scenario)
    assert plan.found, plan.explanation
    assert judge(scenario, plan) == dict.fromkeys(("start", "goal", "free", "feasible"), True)
    assert plan.trajectory is not None
    assert plan.trajectory[0, 2] == scenario.start.velocity


def test_default_primitives_follow_the_road_type() -> None:
    scenario = build_planning_scenario(Boxes3D.empty(), road_type=RoadType.HIGHWAY)
    plan = MotionPrimitivePlanner().plan(scenario)
    assert plan.trajectory is not None
    assert plan.trajectory[:, 2].min() >= 11.0
    # Without a road type there are primitives of all speeds.
    unnamed = MotionPrimitivePlanner().plan(replace(scenario, road_type=None))
    assert unnamed.trajectory is not None
    assert unnamed.trajectory[0, 2] == 11.0


def test_problems_that_cannot_be_posed() -> None:
    scenario = build_planning_scenario(Boxes3D.empty())
    planner = MotionPrimitivePlanner()
    with pytest.raises(PlanningError, match="at least one goal"):
        planner.plan(replace(scenario, goals=()))
    with pytest.raises(PlanningError, match="ends before it begins"):
        planner.plan(replace(scenario, goals=(Goal((5, 4)),)))
    with pytest.raises(PlanningError, match=r"time steps of 0\.2 s"):
        planner.plan(replace(scenario, dt=0.2))
    with pytest.raises(PlanningError, match="no primitive"):
        planner.plan(replace(scenario, start=EgoState(velocity=6.0, steering_angle=0.05)))


def test_what_earlier_searches_left_in_memory_changes_nothing() -> None:
    """A thread has memory of its own: in a new one, a problem is searched in fresh memory."""
    across = np.array([[13.0, y, np.pi / 2] for y in np.arange(-30.0, 31.0, 4.0)])
    location, rotation_y = ego_to_camera(across, 1.65)
    count = len(across)
    sizes = np.tile([1.5, 1.7, 4.1], (count, 1))
    wall = Boxes3D(location, sizes, rotation_y, np.ones(count), np.full(count, "Car"))
    hard = build_planning_scenario(wall, speeds=np.zeros(count), start_speed=6.0)
    planner = MotionPrimitivePlanner(
        primitives=generate_primitives((2.0, 4.0, 6.0, 8.0), steering_angles=21),
        node_limit=4000,
        keep_tree=True,
    )

    def searched(scenario: PlanningScenario) -> tuple[Any, ...]:
        plan = planner.plan(scenario, explain=False)
        return plan.status, plan.expanded, plan.tree

    for scenario in (hard, built(4), hard):
        with ThreadPoolExecutor(1) as fresh:
            expected = fresh.submit(searched, scenario).result()
        np.testing.assert_equal(searched(scenario), expected)
    assert len(searched(hard)[2]) > 2048  # More than there is room for at first.


_PLAIN = """
import numpy as np
from avsec_gym.boxes import Boxes3D
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.scenario.builder import build_planning_scenario

scene = build_planning_scenario(Boxes3D.empty(), road_type="street", intention="straight")
plan = MotionPrimitivePlanner("gbfs").plan(scene, explain=False)
print(plan.status.value, plan.cost, plan.expanded, plan.trajectory.tolist())
"""


@pytest.mark.slow
def test_plans_are_the_same_where_numba_compiles_nothing() -> None:
    """Debuggers and the tests of mutants run the kernels as plain Python."""

    def answer(disabled: str) -> str:
        environment = os.environ | {"NUMBA_DISABLE_JIT": disabled}
        command = [sys.executable, "-c", _PLAIN]
        return subprocess.run(
            command, env=environment, capture_output=True, text=True, check=True
        ).stdout

    assert answer("1") == answer("0") != ""
