"""The example's figures of every environment are kept, and an error is one of them."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from types import SimpleNamespace

import pytest

from studies.attackers import every_environment
from studies.attackers.every_environment import SCRIPT, learned, main


def test_what_the_example_prints_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[list[str]] = []

    def run(command: list[str], **_: object) -> SimpleNamespace:
        asked.append(command[1:])
        if "avsec/Broken-v0" in command:
            return SimpleNamespace(returncode=1, stdout="", stderr="Traceback\nValueError: no\n")
        line = json.dumps({"environment": command[2], "reward": 0.5, "steps_per_second": 7.0})
        return SimpleNamespace(returncode=0, stdout=f"{line}\n", stderr="")

    monkeypatch.setattr(subprocess, "run", run)
    words = ["avsec/GhostObject-v1", "avsec/Broken-v0", "--runs", str(tmp_path)]
    for _ in range(2):
        assert main([*words, "--json", str(tmp_path / "found.json")]) == 0
    assert len(asked) == 2, "the second time nothing is run again"
    assert asked[0] == [SCRIPT, "avsec/GhostObject-v1", "--steps", "1000"]
    good, broken = json.loads((tmp_path / "found.json").read_text())["environments"]
    assert good["error"] is None
    assert good["steps_per_second"] == 7.0
    assert broken == {
        "environment": "avsec/Broken-v0",
        "reward": None,
        "steps_per_second": None,
        "error": "ValueError: no",
    }


@pytest.mark.slow
def test_the_example_itself() -> None:
    found = learned("avsec/GhostObject-v1", 16)
    assert found["error"] is None
    assert found["steps_per_second"] > 0
    assert every_environment.SCRIPT == SCRIPT
