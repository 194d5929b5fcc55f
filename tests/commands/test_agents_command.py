"""`avsec agents`: train, go on, judge, list."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avsec_gym.cli import run

CONFIG = """
avsec/GhostObject-v1:
  n_envs: 4
  n_timesteps: 64
  policy: PlacePolicy
  n_steps: 8
  batch_size: 16
  env_kwargs: {scenarios: {name: layouts, seed: 0, count: 8}}
  eval_env_kwargs: {scenarios: {name: layouts, seed: 7, count: 8}}
"""


@pytest.mark.slow
def test_trained_gone_on_with_and_judged(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config, out = tmp_path / "mine.yml", tmp_path / "agent"
    config.write_text(CONFIG)
    train = ["agents", "train", "GhostObject-v1", "--config", str(config), "--out", str(out)]
    assert run([*train, "--minutes", "0.000001", "--episodes", "10", "--json"]) == 3
    card = json.loads(capsys.readouterr().out)
    assert (card["schema"], card["finished"]) == ("avsec.agents.train/1", False)
    assert run([*train, "--episodes", "10"]) == 1
    assert "--resume" in capsys.readouterr().err
    assert run([*train, "--resume", "--episodes", "10"]) == 0
    assert "finished; 64 steps" in capsys.readouterr().err
    card = json.loads((out / "card.json").read_text())
    assert card["held_out"]["episodes"] == 10
    assert card["eval_env_kwargs"]["scenarios"]["seed"] == 7
    judge = ["agents", "evaluate", str(out), "--episodes", "40", "--queries", "300"]
    assert run([*judge, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["rows"][0]["kind"] == "agent"
    assert len(found["rows"]) == 12
    assert found["against_best_baseline"][0]["agent"] == str(out)
    assert (found["budget"], found["pooled"]) == (300, [])
    assert run(judge) == 0
    shown = capsys.readouterr().out
    assert "interquartile mean" in shown
    assert " points (" in shown


@pytest.mark.slow
def test_seeds_are_pooled_at_each_budget(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "mine.yml"
    config.write_text(CONFIG)
    outs = {}
    for steps, seed in ((32, 0), (32, 1), (64, 0)):
        out = outs[steps, seed] = str(tmp_path / f"{steps}_{seed}")
        train = ["agents", "train", "GhostObject-v1", "--config", str(config), "--out", out]
        assert run([*train, "--steps", str(steps), "--seed", str(seed), "--episodes", "0"]) == 0
    judge = ["agents", "evaluate", *outs.values(), "--episodes", "40", "--budgets", "64", "40"]
    capsys.readouterr()
    assert run([*judge, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "avsec.agents.evaluate.budgets/1"
    small, large = found["budgets"]
    assert (small["budget"], large["budget"]) == (40, 64)
    assert all(row["queries"] <= 40 for row in small["rows"])
    agents = [
        [row["name"] for row in each["rows"] if row["kind"] == "agent"] for each in (small, large)
    ]
    assert agents == [[outs[32, 0], outs[32, 1]], [outs[64, 0]]]
    assert [pool["seeds"] for pool in small["pooled"]] == [[0, 1]]
    assert large["pooled"] == []
    assert run(judge) == 0
    shown = capsys.readouterr().out
    assert "searched with 40 steps" in shown
    assert "probability of improvement" in shown
    assert run([*judge, "--queries", "5"]) == 2
    assert "--budgets and --queries" in capsys.readouterr().err
    assert run([*judge[:-2], "0"]) == 2
    assert "--budgets" in capsys.readouterr().err


def test_what_there_is_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["agents", "list", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert "ppo" in found["configurations"]["avsec/ClosedLoop-v0"]
    assert found["variants"]["defender"] == {"avsec/ClosedLoop-v0": ["ppo", "sac"]}
    assert found["agents"]["ghost_place"]["env"] == "avsec/GhostObject-v1"
    assert run(["agents", "list"]) == 0
    shown = capsys.readouterr().out
    assert "ghost_place" in shown
    assert "defender" in shown


@pytest.mark.parametrize("option", ["--steps 0", "--minutes 0", "--seed -1", "--episodes -1"])
def test_numbers_that_cannot_be(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["agents", "train", "GhostObject-v1", "--out", "nowhere", *option.split()]
    assert run(words) == 2
    assert option.split()[0] in capsys.readouterr().err
