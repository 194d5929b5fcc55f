"""`avsec/ConnectedValidation-v0`: what the base station sees, and what it is paid for."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401
from avsec_gym.envs.connected_validation import REGIONS, ConnectedValidationEnv, evidence_features
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.validator import ConnectedValidator
from tests.validation.connected.conftest import pose_at, scan_of

pytestmark = pytest.mark.usefixtures("small_suite")
ID = "avsec/ConnectedValidation-v0"


@pytest.fixture(scope="module")
def env() -> gym.Env[Any, Any]:
    return gym.make(ID)


def test_only_the_victims_name_wins(env: gym.Env[Any, Any]) -> None:
    id = env.unwrapped.instants.ids[0]  # type: ignore[attr-defined]
    attacked = 0
    for victim in range(3):
        env.reset(seed=victim, options={"scenario": id, "attacked": [victim]})
        played = env.unwrapped._attacked  # type: ignore[attr-defined]
        if played is None:
            continue
        attacked += 1
        for named in range(3):
            env.reset(seed=victim, options={"scenario": id, "attacked": [victim]})
            action = np.arange(3) == named
            _, reward, terminated, truncated, info = env.step(action.astype(np.int8))
            assert reward == float(named == victim)
            assert terminated
            assert not truncated
            assert (info["attacked"], info["named"]) == (str(victim), str(named))
    assert attacked


def test_without_an_attack_silence_wins(env: gym.Env[Any, Any]) -> None:
    _, info = env.reset(seed=1, options={"attacked": []})
    assert info["attacked"] == info["kind"] == ""
    _, reward, *_ = env.step(np.zeros(3, np.int8))
    assert reward == 1.0


def test_the_evidence_of_a_ghost_stands_first() -> None:
    poses = (pose_at(0, 0, 0), pose_at(30, 2, np.pi), pose_at(14, -12, np.pi / 2))
    car, ghost = (14.0, 3.0, 0.1), (15.0, -4.0, -0.2)
    scans = [scan_of(pose, car) for pose in poses]
    scans[1] = scan_of(poses[1], car, ghost)
    station = ConnectedValidator()
    features = evidence_features(station.validate(scans), station)
    assert features.shape == ((REGIONS + 1) * 6 + REGIONS,)
    # Pairs are (0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1): 1 is contradicted by 0 and by 2.
    pairs = features[:6]
    assert (pairs[[2, 3]] > 0.3).all()
    assert (pairs[[0, 1, 4, 5]] <= 0).all()
    assert features[-REGIONS] == features[-REGIONS:].max() > 0.3


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"attacks": ("burn",)}, "burn"),
        ({"attacks": ()}, "one or more"),
        ({"attacks": "paste"}, "attacks are names"),
        ({"unattacked": 2}, "unattacked"),
        ({"variants": 0}, "variants"),
        ({"scenarios": {"source": "connected", "frist": 1}}, "first"),
        ({"scenarios": 3}, "scenarios are"),
        ({"detector": "dsgn"}, "no car drives"),
    ],
)
def test_what_cannot_be_is_refused(arguments: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ConfigurationError, match=complaint):
        ConnectedValidationEnv(**arguments)


def test_options_name_one_vehicle(env: gym.Env[Any, Any]) -> None:
    for wrong in ([3], [0, 1], ["0"], "0", [True]):
        with pytest.raises(ConfigurationError, match="list of one vehicle"):
            env.reset(options={"attacked": wrong})
    with pytest.raises(ConfigurationError, match="no instant"):
        env.reset(options={"scenario": "999999"})
    with pytest.raises(DataError):
        ConnectedValidationEnv(scenarios="no/such/folder")
