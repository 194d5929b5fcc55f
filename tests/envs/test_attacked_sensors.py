"""An attack on sensors that nothing in the car reads is refused when an environment is made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import pytest

import avsec_gym  # noqa: F401
from avsec_gym.built_in_parts import BUILT_IN, Kind
from avsec_gym.envs.attacked_sensors import CAMERAS, READ, SCAN
from avsec_gym.envs.sensor_attack import SensorAttackEnv
from avsec_gym.errors import ConfigurationError
from avsec_gym.kitti.calibration import write_calibration
from avsec_gym.perception.detectors.scan_obstacles import ScanObstacles
from avsec_gym.registration import CATALOGUE
from avsec_gym.rig import kitti_rig

LOOKED_UP = {"oracle", "replayed"}
"""Detectors that stand for any other one."""
AROUND_ANOTHER = {"defended", "attacked"}


def of_attackers() -> dict[str, type[SensorAttackEnv]]:
    """Every environment whose agent attacks sensors of frames, by its id."""
    made = {each.id: gym.envs.registration.load_env_creator(each.entry_point) for each in CATALOGUE}
    return {
        id: env
        for id, env in made.items()
        if isinstance(env, type) and issubclass(env, SensorAttackEnv)
    }


ATTACKERS = of_attackers()


@pytest.fixture
def scenes(tmp_path: Path) -> str:
    """A folder that is there; nothing of it is read."""
    write_calibration(tmp_path / "training" / "calib" / "000001.txt", kitti_rig().calibration)
    (tmp_path / "training" / "label_2").mkdir()
    (tmp_path / "training" / "label_2" / "000001.txt").touch()
    return str(tmp_path)


def test_what_every_detector_reads_is_known() -> None:
    detectors = {name for kind, name in BUILT_IN if kind == Kind.DETECTOR}
    assert detectors == {*READ, *LOOKED_UP, *AROUND_ANOTHER}
    assert {"avsec/FaculaAttack-v0", "avsec/PatchAttack-v0", "avsec/LidarSpoofing-v0"} <= {
        *ATTACKERS
    }


def blind_ones(attacked: str) -> list[Any]:
    found: list[Any] = [n for n, sensor in READ.items() if sensor != attacked]
    found.remove("single_image") if attacked == SCAN else None
    within = {"name": "defended", "detector": "stereo_rcnn" if attacked == SCAN else "pixor"}
    return [*found, within, *([ScanObstacles()] if attacked == CAMERAS else [])]


@pytest.mark.parametrize("id", ATTACKERS)
def test_an_attack_on_what_nothing_reads_is_refused(id: str, scenes: str) -> None:
    attacked = ATTACKERS[id].attacked
    for detector in blind_ones(attacked):
        with pytest.raises(ConfigurationError, match=rf"on the {attacked}, which nothing.*Give a"):
            gym.make(id, scenarios=scenes, detector=detector)


@pytest.mark.parametrize("id", ATTACKERS)
def test_a_detector_or_a_validator_that_reads_it_makes_a_game(id: str, scenes: str) -> None:
    attacked = ATTACKERS[id].attacked
    for detector in (n for n, sensor in READ.items() if sensor == attacked and n != "single_image"):
        gym.make(id, scenarios=scenes, detector=detector)
    if "validator" in ATTACKERS[id].taken_parts.refused:  # type: ignore[attr-defined]
        return
    gym.make(id, scenarios=scenes, detector=blind_ones(attacked)[0], validator="thresholds")
