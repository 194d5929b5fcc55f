"""The example that trains PPO runs with every id of the catalogue, as its users run it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.envs.test_catalogue import IDS, arguments
from tests.envs.test_ppo_learns import CHEAP, RENDERED

SCRIPT = Path(__file__).parents[2] / "examples/any_environment.py"
QUICK = "avsec/GhostObject-v1"


@pytest.mark.parametrize(
    "id", [pytest.param(id, marks=[] if id == QUICK else [pytest.mark.slow]) for id in IDS]
)
def test_the_example_learns_in_every_environment(id: str, request: pytest.FixtureRequest) -> None:
    if id in RENDERED:
        request.getfixturevalue("small_suite")
    given = json.dumps(arguments(id) | CHEAP.get(id, {}))
    command = [sys.executable, str(SCRIPT), id, "--steps", "16", "--arguments", given]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    (line,) = done.stdout.splitlines()
    result = json.loads(line)
    assert result["environment"] == id
    assert np.isfinite(result["reward"])


def test_the_example_takes_every_id_by_itself() -> None:
    program = f"import runpy; print(sorted(runpy.run_path({str(SCRIPT)!r})['IDS']))"
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    assert done.stdout.strip() == str(sorted(IDS))
