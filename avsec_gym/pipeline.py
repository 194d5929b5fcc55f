"""The thesis' chain in one call: what perception believes -> planning scenario -> plan -> verdict.

    b = O(I_l, I_r)               detected objects (here: boxes that somebody hands in)
    b> = C(b, I_l, I_r)           which of them move (`Motion`)
    (s_0, r, d) = S(I_l, I_r)     driving constraints by road type (the scene's)
    {s_t} = M(b>, s_0, r, g, c, d)

and the trajectory {s_t} is held against what is really there.
"""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.boxes import Boxes3D
from avsec_gym.metrics.safety import SafetyRecord, judge
from avsec_gym.planners.plan import Plan
from avsec_gym.planners.planner import MotionPrimitivePlanner, Planner
from avsec_gym.scenario.given_scene import GivenScene
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import Obstacles, PlanningScenario
from avsec_gym.scenario.scene import Motion, Scene


@dataclass(frozen=True, eq=False)
class Drive:
    """One drive through a scene."""

    problem: PlanningScenario
    """What the planner was asked: the world as it was believed to be."""
    plan: Plan
    truth: Obstacles
    """The world as it is."""
    record: SafetyRecord


def drive(
    scene: Scene | GivenScene,
    intention: Intention = Intention.STRAIGHT,
    believed: Boxes3D | None = None,
    *,
    motion: Motion = Motion.TRUTH,
    planner: Planner | None = None,
) -> Drive:
    """Plan on what is believed, judge against what is.

    Args:
        scene: The real situation.
        intention: Where to go; a given scene has its own goal.
        believed: What perception reports; None: the truth.
        motion: What the planner knows of motion.
        planner: Any planner; None: A* over motion primitives.

    Example:
        >>> from avsec_gym.world.layouts import generate_layout
        >>> layout = generate_layout(7)
        >>> scene = Scene(layout.id, layout.boxes, layout.road_type)
        >>> drive(scene).record.outcome
        'safe'
    """
    planner = MotionPrimitivePlanner() if planner is None else planner
    problem = scene.problem(intention, believed, motion)
    plan = planner.plan(problem)
    truth = scene.truth()
    return Drive(problem, plan, truth, judge(plan, problem, truth))
