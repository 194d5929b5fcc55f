"""Rules that shine at what is in the way: what they choose, and where their light falls."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from numpy.typing import NDArray

from avsec_gym.agents.aimed_games import GAMES
from avsec_gym.agents.arena import Arena
from avsec_gym.agents.laser_rules import LaserRule, candidates, features_of, fits, in_order
from avsec_gym.agents.rules import NUMBER, rules_of
from avsec_gym.envs.facula_coding import FaculaCoding
from avsec_gym.geometry import project
from avsec_gym.rig import KITTI_SIZE, kitti_rig

GAME = GAMES["facula_attack"]
ID = "avsec/FaculaAttack-v0"
WAYS = ("left", "straight", "right")
CAMERA = 1.65
WIDTH, HEIGHT = KITTI_SIZE


def pixels(ahead: float, left: float, up: float, camera: int) -> NDArray[np.float64]:
    """Column and row of a point, metres ahead, to the left and above the ground."""
    place = np.array([[-left, CAMERA - up, ahead]])
    return project(kitti_rig().calibration.projection(camera), place)[0][0]


def seen(
    *places: tuple[float, float], way: str = "straight", spent: float = 0.0
) -> NDArray[np.float32]:
    """One observation with objects at places, metres ahead and to the left."""
    observation = np.zeros(GAME.observation, np.float32)
    observation[2 + WAYS.index(way)] = 1.0
    observation[GAME.clock] = 1.0 - spent
    end = GAME.first + GAME.size * len(places)
    rows = observation[GAME.first : end].reshape(len(places), GAME.size)
    for row, (ahead, left) in zip(rows, places, strict=True):
        foot = 2.0 * pixels(ahead, left, 0.0, 2) / [WIDTH - 1, HEIGHT - 1] - 1.0
        row[:3] = 1.0, ahead / 50.0, left / 20.0
        row[list(GAME.seen)] = np.clip(foot, -1.0, 1.0)
    return observation[None]


def order(*places: tuple[float, float], way: str = "straight") -> list[int]:
    return in_order(seen(*places, way=way))[0, : len(places)].tolist()


def test_the_nearest_in_the_way_comes_first() -> None:
    assert order((8.0, 4.0), (20.0, -1.0), (12.0, 1.0)) == [2, 1, 0]
    # On the way into the left lane: between the two half way, and in that lane.
    assert order((20.0, 0.0), (7.5, 1.7), (20.0, 3.5), way="left") == [1, 2, 0]
    assert order((20.0, 3.5), (20.0, -3.5), way="right") == [1, 0]
    # Where none is, the one next to the way.
    assert order((10.0, -6.0), (10.0, 3.0)) == [1, 0]


@pytest.mark.parametrize("place", [(12.0, 0.5), (25.0, -1.5), (40.0, 1.0)])
@pytest.mark.parametrize("right", [False, True])
def test_the_light_falls_on_the_object_in_either_image(
    place: tuple[float, float], right: bool
) -> None:
    """By the camera's own projection, to a few pixels."""
    [action] = LaserRule(10, height=0.75, right_first=right)(seen((5.0, 6.0), place))
    facula = FaculaCoding((HEIGHT, WIDTH), (37.5, 375.0)).decode(action.astype(float))
    assert facula.camera == (3 if right else 2)
    assert facula.radius == pytest.approx(375.0)
    wanted = pixels(*place, 0.75, facula.camera)
    np.testing.assert_allclose(facula.centre, wanted, atol=4.0)


def test_each_further_query_is_another_attempt() -> None:
    """Both cameras at the nearest object, then both at the next, then from the beginning."""
    rule, places = LaserRule(10), ((10.0, 0.0), (20.0, 1.0))
    actions = [rule(seen(*places, spent=query / 10))[0] for query in range(5)]
    assert [action[0] for action in actions] == [-1.0, 1.0, -1.0, 1.0, -1.0]
    assert actions[0][1] != actions[2][1]
    np.testing.assert_allclose(actions[4], actions[0], atol=1e-6)
    # The same object is further to the left in the right image.
    assert actions[1][1] < actions[0][1]


def test_no_object_is_no_error() -> None:
    [action] = LaserRule(1)(seen())
    assert np.isfinite(action).all()


def test_features_are_found_beside_images() -> None:
    both = {"features": seen((10.0, 0.0)), "images": np.zeros((1, 48, 160, 3), np.uint8)}
    np.testing.assert_array_equal(features_of(both), both["features"])
    np.testing.assert_array_equal(LaserRule(1)(both), LaserRule(1)(both["features"]))


def box(*size: int) -> gym.spaces.Box:
    return gym.spaces.Box(-1.0, 1.0, size, np.float32)


def test_what_it_can_play() -> None:
    image = gym.spaces.Box(0, 255, (48, 160, 3), np.uint8)
    assert fits(box(128), box(4))
    assert fits(gym.spaces.Dict({"features": box(128), "images": image}), box(4))
    assert fits(box(129), box(5)), "the strength is chosen, too"
    assert not fits(image, box(4))
    assert not fits(box(177), box(7))
    [action] = LaserRule(1, 5)(seen((10.0, 0.0)))
    assert action.shape == (5,)
    assert action[4] == 1.0, "full light"


@pytest.mark.parametrize("arguments", [{"queries": 1}, {"queries": 1, "observation": "both"}])
def test_rules_are_chosen_in_training_episodes(
    arguments: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The one whose size and height earn most, with no more steps than it was given."""
    arena = Arena(ID, arguments)
    wanted = candidates(1, 4)[6]
    tried: list[float] = []

    def earned(budget: Any, act: Any) -> float:
        action = act(seen((10.0, 0.0)), ["straight"])[0]
        budget.spent += budget.trials
        tried.append(-float(np.abs(action - wanted(seen((10.0, 0.0)))[0]).sum()))
        return tried[-1]

    monkeypatch.setattr("avsec_gym.agents.rules.SearchBudget.tried", earned)
    largest, chosen = rules_of(ID, arena, 64)
    assert NUMBER[ID] == 2
    assert len(tried) == len(candidates(1, 4)) == 16
    assert largest.queries == 0
    assert chosen.queries == 64
    act = chosen.act_in(arena)
    np.testing.assert_allclose(
        act(seen((10.0, 0.0)), ["straight"]), wanted(seen((10.0, 0.0))), atol=1e-6
    )
    assert not list(rules_of(ID, Arena(ID, {"observation": "images"}), 64))
