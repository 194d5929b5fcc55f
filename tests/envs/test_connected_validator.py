"""The validator `connected` in environments: in one query, and in closed loop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.loop_scenes import LoopScenes, loop_scenes
from avsec_gym.closed_loop.procedural_drives import procedural_drive
from avsec_gym.envs.closed_loop_parts import checked_scenarios
from avsec_gym.envs.game_validator import judges_by_others, validator_and_played
from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, make
from avsec_gym.rig import kitti_rig, resized_rig
from avsec_gym.scenario.frame_scenes import frame_scenes_of
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.world.export import Connection, Sensors, make_data_set, suite_recipe

_RIG = resized_rig(kitti_rig(), 128)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two instants of four vehicles, near each other."""
    root = tmp_path_factory.mktemp("connected")
    sensors, near = Sensors((2, 3), rig=_RIG), Connection(spacing=(8, 20))
    recipe = suite_recipe("connected", 2, 1, sensors=sensors, vehicles=4, connection=near)
    make_data_set(recipe, root, workers=1)
    return root


def test_by_name_or_live_it_is_known() -> None:
    assert judges_by_others("connected")
    assert judges_by_others({"name": "connected", "alarms": 0.2})
    assert judges_by_others(make(Kind.VALIDATOR, "connected"))
    assert not judges_by_others("thresholds")


def test_drives_of_several_vehicles_have_ids_of_their_own() -> None:
    assert loop_scenes("drives", seed=2, count=1, vehicles=3).ids == ("drive-s2-v3-000000",)
    assert loop_scenes("drives", count=1).ids == ("drive-000000",)
    with pytest.raises(ConfigurationError, match="vehicles is for drives"):
        loop_scenes("layouts", vehicles=3)
    with pytest.raises(ConfigurationError, match="vehicles"):
        checked_scenarios({"source": "drives", "vehicles": "many"})


@pytest.mark.slow
def test_one_query_of_a_connected_car(data: Path) -> None:
    outcomes: dict[str | None, str] = {}
    for response in ("stop", "repair"):
        environment = gym.make(
            "avsec/DetectorBenchmark-v0",
            scenarios=str(data / "vehicle_0"),
            attack={"name": "lidar_spoofing"},
            validator="connected",
            response=response,
        )
        environment.reset(seed=0, options={"scenario": "000001"})
        nothing = np.full(environment.action_space.shape, -1.0, np.float32)  # type: ignore[arg-type]
        *_, info = environment.step(nothing)
        assert info["alarm"]
        outcomes[response] = info["outcome"]
    # The ghost is named and taken out: the car need not stop.
    assert outcomes["stop"] == "unplanned"
    assert outcomes["repair"] != "unplanned"


@pytest.mark.slow
def test_scenes_of_a_lonely_car_are_refused(data: Path, tmp_path: Path) -> None:
    alone = tmp_path / "alone"
    alone.symlink_to(data / "vehicle_0", target_is_directory=True)
    assert frame_scenes_of(str(alone)).frame(frame_scenes_of(str(alone)).scenes.labelled[0])
    moved = tmp_path / "moved"
    (data / "vehicle_1").rename(moved)
    try:
        with pytest.raises(ConfigurationError, match="cannot judge the scenes"):
            validator_and_played("connected", frame_scenes_of(str(moved)))
    finally:
        moved.rename(data / "vehicle_1")


@pytest.mark.slow
def test_in_closed_loop_the_ghost_is_taken_out_of_what_the_car_believes() -> None:
    scenes = LoopScenes(("drive",), lambda id: procedural_drive(1, 1, rig=_RIG, vehicles=5))

    def driven(**parts: Any) -> Any:
        environment = gym.make(
            "avsec/ClosedLoop-v0",
            scenarios=scenes,
            perception="sensors",
            detector="scan_obstacles",
            disable_env_checker=True,
            **parts,
        )
        environment.reset(seed=0)
        drive: Any = environment.unwrapped
        return drive.perception.perceive(drive.surroundings())

    attack = {"name": "lidar_spoofing", "distance": 8.0, "bearing": 0.0}
    clean, attacked = driven(), driven(attack=attack)
    repaired = driven(attack=attack, validator="connected", response="repair")
    assert repaired.validation.statuses == {LIDAR: SensorStatus.ATTACKED}
    assert not repaired.stops

    def something_ahead(believed: Boxes3D) -> bool:
        return bool((np.hypot(believed.location[:, 0], believed.location[:, 2] - 8.0) < 1.5).any())

    assert something_ahead(attacked.believed)
    assert not something_ahead(clean.believed)
    assert not something_ahead(repaired.believed)
    assert len(repaired.believed) > 0
