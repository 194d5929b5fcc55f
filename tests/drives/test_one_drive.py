"""One drive: its row, held against the single query, and against the same drive on highway-env."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.error_model.model import ErrorModel, Ghosts, Spread
from avsec_gym.closed_loop.perception import TruthPerception
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.envs.closed_loop import ClosedLoopEnv
from avsec_gym.envs.light_closed_loop import LightClosedLoopEnv
from avsec_gym.errors import ConfigurationError
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_sets import procedural_scenes

MODEL = ErrorModel(
    found=(4.0, -1.0, -0.3, -3.0, -3.0, -1.0),
    spreads={
        "radial": Spread(0.1, 0.3, 0.6, 4.0),
        "lateral": Spread(0.0, 0.1, 0.4, 5.0),
        "turn": Spread(0.0, 0.05, 0.2, 3.0),
        "log_length": Spread(0.0, 0.06, 0.0, 6.0),
        "log_width": Spread(0.0, 0.04, 0.0, 6.0),
    },
    turned_round=0.05,
    ghosts=Ghosts(0.5, ((20.0, -2.0, 0.1, 1.5, 1.6, 4.0), (12.0, 3.0, 3.0, 1.4, 1.7, 4.2)), 0.3),
)


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


class Mine(TruthPerception):
    """A perception of another package."""


@pytest.mark.parametrize(
    ("source", "count", "arguments"),
    [
        ("layouts", 12, {"perception": "truth"}),
        ("layouts", 12, {"perception": "blind"}),
        ("layouts", 6, {"perception": "truth", "motion": "static", "duration": 3.3}),
        ("layouts", 8, {"perception": {"name": "error_model", "model": MODEL}}),
        ("layouts", 2, {"perception": Mine()}),
        pytest.param("drives", 3, {"perception": "truth"}, marks=pytest.mark.slow),
        pytest.param(
            "drives",
            3,
            {"perception": {"name": "error_model", "model": MODEL}},
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_drive_without_highway_env_is_the_drive_on_it(
    source: str, count: int, arguments: dict[str, Any]
) -> None:
    """Rows and films, byte for byte, of drives that end in several ways."""
    scenarios = {"source": source, "count": count}
    light = DriveSetting("car", arguments).environment(scenarios)
    on_highway_env = gym.make(
        "avsec/ClosedLoop-v0", scenarios=scenarios, disable_env_checker=True, **arguments
    )
    assert isinstance(light, LightClosedLoopEnv)
    assert isinstance(on_highway_env.unwrapped, ClosedLoopEnv)
    outcomes = set()
    for number, id in enumerate(light.scenes.ids):
        ways = [str(each) for each in light.scenes.scene(id).intentions]
        task = DriveTask("car", id, ways[number % len(ways)], number)
        made, known = drive(light, task), drive(on_highway_env, task)
        assert made.row == known.row
        assert made.film.content() == known.film.content()
        outcomes.add(made.row["outcome"])
    assert count < 12 or len(outcomes) > 1


@pytest.mark.parametrize(("source", "count"), [("layouts", 8), ("drives", 2)])
def test_who_makes_no_plans_has_a_row_and_a_film_without_any(source: str, count: int) -> None:
    """highway-env's driver, the same drive with highway-env and without; the file is a film."""
    scenarios = {"source": source, "count": count}
    setting = DriveSetting("follower", {"perception": "truth"}, "idm")
    light = setting.environment(scenarios)
    on_highway_env = gym.make("avsec/ClosedLoop-v0", scenarios=scenarios, disable_env_checker=True)
    for number, id in enumerate(light.unwrapped.scenes.ids):  # type: ignore[attr-defined]
        task = DriveTask("follower", id, "straight", number)
        made, known = (drive(each, task, setting.driver) for each in (light, on_highway_env))
        assert made.row == known.row
        assert made.film.content() == known.film.content()
        assert (made.row["first_plan"], made.row["emergency_stops"]) == ("unplanned", 0)
        assert (made.film.planned == -1).all()
        assert not made.film.stops.any()
        assert not len(made.film.plans)


def test_a_driver_that_is_unknown_is_refused_with_its_setting() -> None:
    for driver, message in (("idn", 'setting far.*mean "idm"'), ({"name": "idm", "x": 1}, "'x'")):
        with pytest.raises(ConfigurationError, match=message):
            DriveSetting("far", {"perception": "blind"}, driver).environment("layouts")


@pytest.mark.parametrize(
    "arguments",
    [
        {"traffic": "reacting"},
        {"traffic": {"name": "reacting", "ids": [0]}},
        {"config": {"simulation_frequency": 40}},
        {"perception": "sensors"},
    ],
)
def test_what_needs_highway_env_or_sensors_drives_on_it(arguments: dict[str, Any]) -> None:
    made = DriveSetting("car", arguments).environment({"source": "drives", "count": 1})
    assert isinstance(made.unwrapped, ClosedLoopEnv)
