"""One drive: its row, held against the single query."""

from __future__ import annotations

from avsec_gym.boxes import Boxes3D
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import procedural_scenes


def test_the_first_plan_of_a_blind_car_has_the_single_querys_outcome() -> None:
    """Who sees nothing takes every plan for fail-safe: the first is the single query's."""
    count = 16
    environment = DriveSetting("blind", {"perception": "blind", "duration": 1.0}).environment(
        {"source": "layouts", "count": count, "people": False}
    )
    outcomes = []
    for scene in procedural_scenes(count).labelled:
        single = run_episode(scene, Intention.STRAIGHT, Boxes3D.empty())
        made = drive(environment, DriveTask("blind", scene.id, "straight", 0))
        assert made.row["first_plan"] == single.record.outcome
        outcomes.append(single.record.outcome)
    assert {"safe", "collision"} <= set(outcomes)
