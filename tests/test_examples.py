"""The examples run as their users run them, in a short form."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import cv2
import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
MOST_LINES = 40
"""Docstring and imports included; what is more is a study, or the package's."""


@pytest.mark.parametrize("script", sorted(EXAMPLES.rglob("*.py")), ids=lambda path: path.name)
def test_an_example_is_read_on_one_screen(script: Path) -> None:
    assert len(script.read_text().splitlines()) <= MOST_LINES


@pytest.mark.slow
def test_a_trained_attacker_beats_rules_on_held_out_layouts() -> None:
    command = [sys.executable, str(EXAMPLES / "train_ghost_attacker.py")]
    command += ["--steps", "100000", "--held-out", "300"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    result = {
        name: row for line in done.stdout.splitlines() for name, row in json.loads(line).items()
    }
    rules = [result[name]["interval"][1] for name in ("random", "first", "nearest")]
    assert result["ppo"]["interval"][0] > max(rules)


@pytest.mark.slow
def test_an_attacker_on_a_driving_car_is_trained_and_judged() -> None:
    script = EXAMPLES / "train_closed_loop_attacker.py"
    command = [sys.executable, str(script), "--steps", "64", "--held-out", "2"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    result = json.loads(done.stdout)
    assert list(result) == ["ppo", "random"]
    assert all(0 <= won <= 2 for won in result.values())


@pytest.mark.slow
def test_a_planner_drives_on_by_what_its_car_believes() -> None:
    command = [sys.executable, str(EXAMPLES / "drive_on.py"), "--episodes", "2"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    rows = {row["car"]: row for row in map(json.loads, done.stdout.splitlines())}
    assert list(rows) == ["truth", "blind", "dsgn", "dsgn_thesis_pgd"]
    assert rows["truth"] == {"car": "truth", "drives": 2, "safe": 2, "at_fault": 0}


@pytest.mark.slow
def test_rules_that_attack_a_driving_car_are_chosen_and_judged() -> None:
    script = EXAMPLES.parent / "benchmarks/closed_loop_attackers.py"
    command = [sys.executable, str(script), "--episodes", "1", "--held-out", "2"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    held_out = json.loads(done.stdout)["held_out"]
    assert list(held_out) == ["nothing", "random", "constant", "waits", "when it plans"]
    assert held_out["nothing"]["won"] == 0


@pytest.mark.slow
def test_an_agent_of_highway_env_drives_in_our_scenes() -> None:
    script = EXAMPLES / "highway_agent.py"
    command = [sys.executable, str(script), "--steps", "16", "--drives", "2"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    result = json.loads(done.stdout)
    assert list(result) == ["ppo", "idle"]
    assert all(sum(outcomes.values()) == 2 for outcomes in result.values())


@pytest.mark.slow
def test_the_page_for_users_of_highway_env_is_true() -> None:
    """Its block asserts that the spaces are the same."""
    text = (EXAMPLES.parent / "docs" / "from_highway_env.md").read_text()
    (block,) = (part.split("```")[0] for part in text.split("```python\n")[1:])
    subprocess.run([sys.executable, "-c", block], check=True, capture_output=True)


@pytest.mark.slow
def test_two_ghosts_make_most_drives_unsafe(tmp_path: Path) -> None:
    command = [sys.executable, str(EXAMPLES / "attack_detections.py")]
    command += ["--scenes", "6", "--out", str(tmp_path / "new")]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    rates = json.loads(done.stdout)["rates"]
    safe = {
        name: sum(row["safe_driving_rate"] for row in rates if row["input"] == name)
        for name in ("ground_truth", "ghost_attack")
    }
    assert safe["ghost_attack"] < safe["ground_truth"] / 2
    assert cv2.imread(str(tmp_path / "new" / "sheet.png")).std() > 5


@pytest.mark.slow
def test_a_ghost_is_named_over_bad_lines() -> None:
    command = [sys.executable, str(EXAMPLES / "connected_sockets.py"), "--doubled", "0.3"]
    # Time enough for a machine that does other things meanwhile.
    command += ["--seconds", "15"]
    done = subprocess.run(
        [*command, "--malformed", "0.03"], check=True, capture_output=True, text=True, timeout=300
    )
    *instants, left_out = done.stdout.splitlines()
    assert len(instants) == 5
    assert sum(line.endswith("named at the ghost [1]") for line in instants) >= 3
    assert "doubled" in left_out


def test_the_readmes_python_runs() -> None:
    """The blocks of the first screen, as a newcomer copies them."""
    text = (EXAMPLES.parent / "README.md").read_text()
    blocks = [part.split("```")[0] for part in text.split("```python\n")[1:]]
    assert len(blocks) == 2
    for block in blocks:
        subprocess.run([sys.executable, "-c", block], check=True, capture_output=True)
