"""`avsec/ConnectedSpoofing-v0`: where ghosts stand, what is reported of them, and what wins."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401
from avsec_gym.envs.connected_spoofing import PLACE, ConnectedSpoofingEnv, scene_features
from avsec_gym.errors import ConfigurationError
from tests.validation.connected.conftest import pose_at, scan_of

pytestmark = pytest.mark.usefixtures("small_suite")
ID = "avsec/ConnectedSpoofing-v0"


@pytest.fixture(scope="module")
def env() -> gym.Env[Any, Any]:
    return gym.make(ID)


def test_the_ghost_stands_where_the_action_says(env: gym.Env[Any, Any]) -> None:
    env.reset(seed=2)
    played: Any = env.unwrapped
    for victim, value in enumerate((-0.9, 0.0, 0.9)):
        for bearing in (-2.0, 0.5, 2.5):
            place = PLACE.encode(np.array([12.0, bearing]))
            *_, info = env.step(np.array([value, -1.0, *place], np.float32))
            assert info["victim"] == victim
            assert info["distance"] == pytest.approx(12.0, abs=1e-4)
            if info["blocked"]:
                assert info["points"] == 0
                continue
            scan = played._attacked.instant.scans[victim].compensated().points
            ghost = scan[len(scan) - info["points"] :, :3].mean(axis=0)
            assert np.hypot(*ghost[:2]) == pytest.approx(12.0, abs=3.0)
            off = np.arctan2(ghost[1], ghost[0]) - bearing
            assert abs((off + np.pi) % (2 * np.pi) - np.pi) < 0.25
            if played._result is not None:
                assert info["is_success"] == (info["believed"] and not info["alarm"])


def test_a_query_costs_its_price_and_the_budget_ends() -> None:
    env = ConnectedSpoofingEnv(queries=2, price=0.1)
    env.reset(seed=0)
    ends = []
    for _ in range(2):
        _, reward, terminated, truncated, info = env.step(np.zeros(4, np.float32))
        assert reward == pytest.approx(float(info["is_success"]) - 0.1)
        assert not info["is_success"]
        ends.append((terminated, truncated))
    assert ends == [(False, False), (True, False)]


def test_the_scene_shows_where_others_are_and_what_stands() -> None:
    # A car to the left of vehicle 0; vehicle 1 stands 30 m ahead and faces it.
    scans = (scan_of(pose_at(0, 0, 0), (0.0, 12.0, 0.0)), scan_of(pose_at(30, 0, np.pi)))
    features = scene_features(scans)
    assert features[:4] == pytest.approx([0.5, 0.0, -1.0, 0.0], abs=1e-6)
    assert features[4:8] == pytest.approx([0.5, 0.0, -1.0, 0.0], abs=1e-6)
    sectors = features[8:20] * 60.0
    # Sectors of 30 degrees, from behind by way of the right: its left is where the ninth ends.
    assert sectors.argmin() in (8, 9)
    assert sectors.min() == pytest.approx(12.0 - 0.9, abs=0.3)
    assert (features[20:] == 1.0).all()


def test_what_cannot_be_is_refused() -> None:
    for arguments, complaint in (
        ({"queries": 0}, "queries"),
        ({"price": 2}, "price"),
        ({"attack": "paste"}, "the agent plays it"),
        ({"validator": "thresholds"}, "what is spoofed"),
    ):
        with pytest.raises(ConfigurationError, match=complaint):
            ConnectedSpoofingEnv(**arguments)  # type: ignore[arg-type]
    with pytest.raises(gym.error.ResetNeeded):
        ConnectedSpoofingEnv().step(np.zeros(4))
