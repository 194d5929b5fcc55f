"""A command that is asked to end says so and leaves nothing behind, as after Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from avsec_gym.errors import DataError
from avsec_gym.runs.run_folder import RunFolder


def one(process: subprocess.Popen[str], number: int) -> None:
    process.send_signal(number)


def group(process: subprocess.Popen[str], number: int) -> None:
    """As `timeout`, a service manager and a terminal do: the workers get it, too."""
    os.killpg(process.pid, number)


def stored(root: Path) -> int:
    """How many cells a run has kept; 0 where there is none yet."""
    try:
        return len(RunFolder.open(root).cells())
    except DataError:
        return 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("workers", "send", "number"),
    [
        (0, one, signal.SIGTERM),
        (2, one, signal.SIGTERM),
        (2, group, signal.SIGTERM),
        (2, group, signal.SIGINT),
        (2, group, signal.SIGHUP),
    ],
)
def test_a_run_ends_when_asked_to(
    tiny: ModuleType,
    diary: Path,
    tmp_path: Path,
    workers: int,
    send: Callable[[subprocess.Popen[str], int], None],
    number: signal.Signals,
) -> None:
    root = tmp_path / "run"
    options = ["--workers", str(workers), "--threads", "1", "--options", "pause=0.5"]
    options += ["--limit", "40", "--out", str(root)]
    process = subprocess.Popen(
        [sys.executable, "-m", "avsec_gym", "run", f"{tiny.__name__}:PRECISION", *options],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        start_new_session=True,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not stored(root) and process.poll() is None:
        time.sleep(0.1)
    send(process, number)
    _, told = process.communicate(timeout=60)
    assert told.endswith("avsec: stopped\n"), told
    assert "Traceback" not in told
    assert "leaked" not in told
    assert process.returncode == 128 + number
    workers_left = {int(line.split()[-1]) for line in diary.read_text().splitlines()}
    deadline = time.monotonic() + 10
    while any(Path(f"/proc/{each}").exists() for each in workers_left):
        assert time.monotonic() < deadline, "a worker is left behind"
        time.sleep(0.05)
    assert 0 < stored(root) < 80
