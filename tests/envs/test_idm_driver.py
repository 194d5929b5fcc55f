"""highway-env's driver at the wheel, held against the model that it is named after."""

from __future__ import annotations

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401 - registers the environments
from avsec_gym.closed_loop.loop_scenes import LoopScenes
from avsec_gym.closed_loop.perception import TruthPerception
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.closed_loop.tracks import Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene, thesis_road
from avsec_gym.envs.idm_driver import IdmDriver
from avsec_gym.errors import ConfigurationError
from avsec_gym.pipeline import Perception
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.planning_scenario import EgoState


def driven(places: list[tuple[float, float]], speed: float, **arguments: Any) -> tuple[Any, Any]:
    """The environment and its last info, after a drive past cars that go along the road."""
    count = len(places)
    tracks = Tracks.at_constant_velocity(
        np.full(count, "Car"),
        np.tile([1.5, 1.7, 4.0], (count, 1)),
        np.array([(x, y, 0.0) for x, y in places]).reshape(count, 3),
        np.full(count, speed),
        np.full(count, 1.65),
        400,
    )
    start = EgoState(velocity=6.0)
    scene = TrafficScene("row", thesis_road(), RoadType.STREET, start, tracks, (6.0, 8.0))
    intention = arguments.pop("intention", "straight")
    env = gym.make(
        "avsec/ClosedLoop-v0", scenarios=LoopScenes(("row",), lambda id: scene), **arguments
    )
    driver = IdmDriver(env)
    seen, info = env.reset(seed=0, options={"intention": intention})
    while env.unwrapped.outcome is None:  # type: ignore[attr-defined]
        action, _ = driver.predict(seen)
        assert env.action_space.contains(action)
        seen, *_, info = env.step(action)
    return env.unwrapped, info


def test_it_keeps_the_models_distance_to_what_drives_ahead() -> None:
    """In equilibrium (s0 + v T) / sqrt(1 - (v / v0)^4), between centres, as highway-env counts."""
    lead = 4.0
    env, _ = driven([(25.0, 0.0)], lead, duration=30.0)
    state = env.state
    [(ahead, _, _)] = env.traffic.poses()
    assert state.velocity == pytest.approx(lead, abs=0.05)
    expected = (10.0 + 1.5 * lead) / math.sqrt(1 - (lead / 8.0) ** 4)
    assert ahead - state.x == pytest.approx(expected, abs=0.3)


@pytest.mark.parametrize(("intention", "lane"), [("left", 3.5), ("right", -3.5), ("straight", 0.0)])
def test_it_drives_to_the_lane_of_the_intention(intention: str, lane: float) -> None:
    env, info = driven([], 0.0, intention=intention)
    assert (info["outcome"], info["is_success"]) == ("goal", True)
    assert env.state.y == pytest.approx(lane, abs=0.3)
    assert abs(env.state.heading) < 0.05
    beyond = env.log().car[:, 1] - lane
    assert np.abs(beyond).max() < 3.6, "it does not swing beyond the lane"


def test_it_stays_where_a_change_would_make_one_behind_brake_hard() -> None:
    """A car that comes up at twice the speed in the other lane would have to brake."""
    env, _ = driven([(-12.0, 3.5)], 14.0, intention="left", duration=1.5)
    assert abs(env.state.y) < 1e-6
    # Far enough behind, the change has begun by then.
    env, _ = driven([(-80.0, 3.5)], 6.0, intention="left", duration=1.5)
    assert env.state.y > 0.1


class Alarmed(TruthPerception):
    """An alarm at every frame."""

    def perceive(self, surroundings: Surroundings) -> Perception:
        boxes = surroundings.boxes
        return Perception(boxes, boxes, surroundings.road_type, stops=True)


def test_it_brakes_fully_at_an_alarm() -> None:
    env, info = driven([], 0.0, perception=Alarmed())
    assert info["outcome"] == "stopped"
    assert env.state.x == pytest.approx(6.0**2 / 16.0, abs=1e-6)


def test_it_needs_continuous_actions() -> None:
    env = gym.make("avsec/ClosedLoop-v0", config={"action": {"type": "DiscreteMetaAction"}})
    with pytest.raises(ConfigurationError, match="continuous"):
        IdmDriver(env)
