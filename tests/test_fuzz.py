"""Damaged files of every kind that users give are read soundly or refused by name: a short fuzz.

`python benchmarks/fuzz` is the long one; docs/data.md has its counts.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

FUZZ = Path(__file__).parents[1] / "benchmarks" / "fuzz"
sys.path.append(str(FUZZ))
from patience import answers_in  # noqa: E402


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


@pytest.mark.slow
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


@contextmanager
def _process(code: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, "-c", f"import os, sys, threading, time; {code}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        try:
            yield process
        finally:
            process.kill()


def _answers(process: subprocess.Popen[str], patience: float) -> bool:
    assert process.stdout is not None
    return answers_in(process.stdout, process.pid, patience)


BEGUN = 'print("begun", flush=True); '
COMPUTE = 'exec("while True: pass")'


@pytest.mark.parametrize(
    "code",
    [
        COMPUTE,
        "time.sleep(1000)",
        "threading.Event().wait()",
        "os.read(os.pipe()[0], 1)",
        'exec("while True: time.sleep(0.05)")',
        f"threading.Thread(target=lambda: {COMPUTE}).start()",
    ],
    ids=["loop", "sleep", "lock", "pipe", "polling", "thread"],
)
def test_a_process_that_computes_or_waits_for_ever_hangs(code: str) -> None:
    with _process(BEGUN + code) as process:
        assert not _answers(process, 1.0)


def test_an_answer_and_an_end_are_no_hang() -> None:
    for code in ('time.sleep(0.6); print("done"); time.sleep(0)', "time.sleep(0.6); sys.exit(3)"):
        with _process(BEGUN + code) as process:
            assert _answers(process, 60.0)


def test_a_process_that_gets_no_cpu_does_not_hang() -> None:
    """It is stopped for longer than the patience: a machine that does other things is no fault."""
    with _process(BEGUN + COMPUTE.replace("True", "time.process_time() < 0.8")) as process:
        process.send_signal(signal.SIGSTOP)
        resume = subprocess.Popen(["sh", "-c", f"sleep 4; kill -CONT {process.pid}"])
        begun = time.monotonic()
        assert _answers(process, 2.0)
        assert time.monotonic() - begun > 3.5
        resume.wait()
