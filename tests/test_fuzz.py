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
