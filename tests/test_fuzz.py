"""Damaged files of every kind that users give are read soundly or refused by name: a short fuzz.

`python benchmarks/fuzz` is the long one; docs/data.md has its counts.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

FUZZ = Path(__file__).parents[1] / "benchmarks" / "fuzz"


@pytest.mark.slow
def test_a_damaged_file_is_read_soundly_or_refused_by_name() -> None:
    command = [sys.executable, str(FUZZ), "--files", "12", "--seed", "2026"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900)
    assert done.stdout, done.stderr
    result = json.loads(done.stdout)
    assert result["faults"] == []
    assert done.returncode == 0
    # Neither is everything refused, nor is everything read.
    assert min(result["total"]["read"], result["total"]["refused"]) > 20


def test_a_stopped_fuzz_goes_on_after_the_kinds_that_were_done(tmp_path: Path) -> None:
    done = tmp_path / "runs" / "done.jsonl"  # A fresh checkout has no folder of runs.

    def fuzz(seed: int) -> str:
        command = [sys.executable, str(FUZZ), "--files", "3", "--seed", str(seed)]
        command += ["--kinds", "split", "--done", str(done)]
        return subprocess.run(command, capture_output=True, text=True, timeout=300).stdout

    first = fuzz(1)
    assert fuzz(1) == first
    assert len(done.read_text().splitlines()) == 1
    # What was found with another seed does not count.
    assert json.loads(fuzz(2))["seed"] == 2
    assert len(done.read_text().splitlines()) == 2
    # A kept line is believed, so that nothing is done twice.
    row = json.loads(done.read_text().splitlines()[0])
    row["counts"] = {"read": 41}
    done.write_text(json.dumps(row) + "\n")
    assert json.loads(fuzz(1))["total"]["read"] == 41
