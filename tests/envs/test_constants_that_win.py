"""Games in which an agent that does not look wins often say so at their beginning."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import load_env_creator

from avsec_gym.agents.arena import Arena
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.registration import CATALOGUE
from tests.envs.test_catalogue import make

RESULTS = Path(__file__).parents[2] / "studies/results"
NONE_IS_RIGHT = ["avsec/SensorIdentification-v0", "avsec/ConnectedValidation-v0"]
MOST = 0.35
"""Of episodes, that a constant may win without a word."""


def first_paragraph(id: str) -> str:
    """What stands below the summary line, on one line."""
    doc = load_env_creator(gym.spec(id).entry_point).__doc__ or ""  # type: ignore[arg-type]
    return " ".join(doc.split("\n\n")[1].split())


def test_what_reporting_nothing_wins_is_the_measured_figure() -> None:
    rows = json.loads((RESULTS / "detector_ranking.json").read_text())
    (nothing,) = (row for row in rows if row["detector"] == "nothing")
    low, high = nothing["interval"]
    assert nothing["safe_driving_rate"] > MOST
    stated = first_paragraph("avsec/DetectorBenchmark-v0")
    assert f"{nothing['safe_driving_rate']:.1%}".replace("%", " %") in stated
    assert f"{100 * low:.1f} to {100 * high:.1f} %" in stated


@pytest.mark.parametrize("id", [entry.id for entry in CATALOGUE])
def test_a_share_without_an_attack_is_a_share_that_a_constant_wins(id: str) -> None:
    """Where naming none is an answer, the default share of such episodes is stated."""
    from inspect import signature

    creator = load_env_creator(gym.spec(id).entry_point)  # type: ignore[arg-type]
    share = signature(creator).parameters.get("unattacked")
    assert (share is not None) == (id in NONE_IS_RIGHT)
    if share is not None and share.default > MOST:
        assert f"{100 * share.default:.0f} % of them have no attack" in first_paragraph(id)


def test_a_constant_that_solves_a_game_is_in_its_first_paragraph() -> None:
    assert first_paragraph("avsec/GhostObject-v0").startswith("**Solved by a constant.**")


def test_a_constant_that_wins_often_when_searched_is_in_the_first_paragraph() -> None:
    """With the measured rate, unless the game is called solved."""
    place = RESULTS / "constants.json"
    if not place.is_file():
        pytest.skip("no constant has been searched yet: python -m studies.constants")
    for name, found in json.loads(place.read_text())["games"].items():
        rate, (low, high) = found["held_out"]["rate"], found["held_out"]["interval"]
        stated = first_paragraph(found["env"])
        by_default = f"avsec/{name}" == found["env"]
        if by_default and rate > MOST and not stated.startswith("**Solved by a constant.**"):
            figure = f"wins {100 * rate:.1f} % ({100 * low:.1f} to {100 * high:.1f} %)"
            assert figure in stated, f"{name} states that a constant {figure}"


@pytest.mark.slow
@pytest.mark.usefixtures("small_suite")
def test_the_largest_patch_ahead_wins_against_the_default_car() -> None:
    assert first_paragraph("avsec/LidarSpoofing-v0").startswith("**Solved by a constant.**")
    env = gym.make("avsec/LidarSpoofing-v0")
    for seed in range(6):
        env.reset(seed=seed)
        assert env.step(np.array([-1, 0, 1, 1], np.float32))[4]["is_success"], seed
    env.close()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "form"),
    [
        ({}, "{:.1f} % of 200 episodes"),
        ({"scenarios": {"source": "layouts", "seed": 7, "count": 200}}, "it is {:.1f} %"),
    ],
    ids=["drives", "layouts"],
)
def test_what_doing_nothing_wins_is_the_measured_figure(
    arguments: dict[str, Any], form: str
) -> None:
    arena = Arena("avsec/ClosedLoop-v0", arguments)
    size = arena.environment.action_space.shape or ()
    found = arena.play(lambda seen, ways: np.zeros((len(ways), *size), np.float32), range(200))
    arena.close()
    share = share_of(found.success, found.scenario.tolist())
    stated = first_paragraph("avsec/ClosedLoop-v0")
    assert form.format(100 * (share.rate or 0.0)) in stated
    low, high = share.interval or (0.0, 0.0)
    assert f"{100 * low:.1f} to {100 * high:.1f} %" in stated


@pytest.mark.slow
@pytest.mark.usefixtures("small_suite")
@pytest.mark.parametrize("id", NONE_IS_RIGHT)
@pytest.mark.parametrize(("unattacked", "wins"), [(1.0, True), (0.0, False)])
def test_naming_none_is_right_where_there_is_no_attack_alone(
    id: str, unattacked: float, wins: bool
) -> None:
    env = make(id, unattacked=unattacked)
    none = np.zeros(env.action_space.shape, np.int8)  # type: ignore[arg-type]
    for seed in range(3):
        env.reset(seed=seed)
        assert env.step(none)[4]["is_success"] == wins
    env.close()
