"""Whatever is given for an argument of an environment: it is played, or refused by `gym.make`.

The entry points and their arguments are read from the catalogue, so that a new environment, and a
new argument of an old one, is covered by itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import load_env_creator

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.registration import CATALOGUE
from tests.envs.test_catalogue import arguments
from tests.envs.test_names import ENTRY_POINTS, parameters
from tests.strange_values import STRANGE

pytestmark = pytest.mark.usefixtures("small_suite")

CASES = [
    pytest.param(point, name, id=f"{point.rpartition(':')[2]}-{name}")
    for point in ENTRY_POINTS
    for name in parameters(point)
]
NAMES_DATA = ("scenarios", "clean", "patch")
"""A text is taken for a file's or a folder's name there, and may be missing."""
SUITS_THE_SCENES = ("clean", "contested", "sensors")
"""Whether they can be played with this value, only the frames show, which are read at a reset."""
every_point = pytest.mark.parametrize(
    "point", ENTRY_POINTS, ids=[point.rpartition(":")[2] for point in ENTRY_POINTS]
)


def usual(point: str) -> dict[str, Any]:
    """What the catalogue's tests play with, the same for an entry point of many at once."""
    [entry] = [e for e in CATALOGUE if point in (e.entry_point, e.vector_entry_point)]
    given = arguments(entry.id)
    return given | ({"scenarios": {"name": "layouts", "count": 24}} if "ghost" in point else {})


def made(point: str, **given: Any) -> Any:
    return load_env_creator(point)(**usual(point) | given)


def play(point: str, name: str, value: Any) -> None:
    """Make an environment, reset it and take a step; only making it may raise one of our errors."""
    try:
        env = made(point, **{name: value})
    except ConfigurationError:
        return
    except DataError:
        assert name in NAMES_DATA
        assert isinstance(value, str | Path | list | dict)
        return
    try:
        env.reset(seed=0)
    except ConfigurationError:
        assert name in SUITS_THE_SCENES
        return
    env.action_space.seed(0)
    observation, reward, *_ = env.step(env.action_space.sample())
    assert env.observation_space.contains(observation)
    assert np.isfinite(reward).all()
    env.close()


@pytest.mark.parametrize(("point", "name"), CASES)
def test_anything_is_played_or_refused_when_it_is_made(point: str, name: str) -> None:
    for value in STRANGE:
        try:
            play(point, name, value)
        except BaseException as error:
            error.add_note(f"{name} = {value!r}"[:200])
            raise


ACCEPTED_ONCE = (
    ("queries", 1.5),
    ("price", -1),
    ("image", "yes"),
    ("shared", "no"),
    ("rays_lost", "no"),
    ("contested", 2),
    ("strength", 1e9),
    ("distances", (5, 1e9)),
    ("bearings", (-100, 100)),
    ("waves", 10**6),
    ("num_envs", 10**9),
    ("max_boxes", 10**9),
    ("points", 10**10),
    ("ghosts", 10**9),
    ("motion", "classifier"),
)


@every_point
def test_what_is_out_of_range_is_refused(point: str) -> None:
    """The strange values above may be played where they make sense; these never do."""
    for name, value in ACCEPTED_ONCE:
        if name in parameters(point):
            with pytest.raises(ConfigurationError, match=name):
                made(point, **{name: value})


ATTACKS = ([], (), [1], (1, 1), (2, 1), [1, 2, 3])
"""Of the strange values, those that name sensors of `avsec/SensorIdentification-v0`."""


@every_point
def test_strange_options_are_refused(point: str) -> None:
    env = made(point)
    env.reset(seed=0)
    for value in STRANGE:
        if value is not None:
            refused(env, {"scenario": value})
            refused(env, {"intention": value})
        if not (isinstance(value, Mapping) and not value) and value is not None:
            refused(env, value)
        if not any(type(value) is type(each) and value == each for each in ATTACKS):
            refused(env, {"attacked": value})
    refused(env, {"scene": "000001"})
    env.reset(seed=0, options={})
    env.reset(seed=0, options={"scenario": None, "intention": None})


def refused(env: Any, options: Any) -> None:
    try:
        with pytest.raises(ConfigurationError):
            env.reset(seed=0, options=options)
    except BaseException as error:
        error.add_note(f"options = {options!r}"[:200])
        raise


VECTORS = [entry.vector_entry_point for entry in CATALOGUE if entry.vector_entry_point]


@pytest.mark.parametrize("point", VECTORS, ids=[point.rpartition(":")[2] for point in VECTORS])
def test_strange_seeds_and_masks_of_many_are_refused(point: str) -> None:
    env = made(point, num_envs=2)
    for wrong in ("a", 1.5, -1, [1], [1, 2, 3], [1, "a"], [1, -1], {}, True):
        with pytest.raises(ConfigurationError, match="seed"):
            env.reset(seed=wrong)
    for mask in (5, "a", None, [True, False], np.ones(3, bool), np.ones(2), np.ones((2, 1), bool)):
        with pytest.raises(ConfigurationError, match="reset_mask"):
            env.reset(options={"reset_mask": mask})
    env.reset(seed=[4, None])
    env.reset(options={"reset_mask": np.array([True, False])})


@pytest.mark.parametrize("entry", CATALOGUE, ids=[entry.id for entry in CATALOGUE])
def test_gym_make_refuses_it_in_the_same_words(entry: Any) -> None:
    """Gymnasium neither rewords these errors nor makes anything else of them."""
    every = parameters(entry.entry_point)
    usual_names = ("price", "points", "most", "duration", "variants")
    name = next(name for name in usual_names if name in every)
    with pytest.raises(ConfigurationError, match=f"^{name} takes a"):
        gym.make(entry.id, **{name: "a"})
    with pytest.raises(ConfigurationError, match=f"^{name} takes a"):
        gym.make_vec(entry.id, num_envs=2, **{name: "a"})
