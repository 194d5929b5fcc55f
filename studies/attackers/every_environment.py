"""Run `examples/any_environment.py` in every environment of the catalogue; prints JSON.

    python -m studies.attackers.every_environment --runs runs/every --json every_environment.json

PPO of stable-baselines3 learns for some steps in each, with its default arguments: how many steps a
second that makes, what it earns then, and which error there was, if any.  Two processes run at a
time, of one thread each.  What is finished is kept in --runs, so that a command that was stopped
goes on there.  Remove the folder where sources have changed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from avsec_gym.console import progress
from avsec_gym.registration import CATALOGUE
from avsec_gym.storage.json_files import read_json
from avsec_gym.storage.regular_files import is_file
from avsec_gym.storage.text_files import write_text
from avsec_gym.worker_processes import THREAD_VARIABLES
from studies.answer import answer
from studies.study import ROOT

SCRIPT = "examples/any_environment.py"


def run(options: argparse.Namespace) -> dict[str, Any]:
    """Run what is not kept, and put all together.

    Args:
        options: Those of `main`.
    """
    ids = options.ids or [entry.id for entry in CATALOGUE]
    waiting = [id for id in ids if not is_file(_place(options, id))]
    with ThreadPoolExecutor(options.workers) as pool, progress("environments") as shown:
        jobs = {pool.submit(learned, id, options.steps): id for id in waiting}
        for done, job in enumerate(as_completed(jobs), start=1):
            text = json.dumps(job.result(), indent=1) + "\n"
            write_text(_place(options, jobs[job]), text, overwrite=True)
            shown(done, len(waiting))
    found = [read_json(_place(options, id), remedy="Remove it, and it is made anew.") for id in ids]
    return {"script": SCRIPT, "steps": options.steps, "environments": found}


def learned(id: str, steps: int) -> dict[str, Any]:
    """What the example prints of an environment, or the last line of its error.

    Args:
        id: The environment.
        steps: Steps of the training.
    """
    ended = subprocess.run(
        [sys.executable, SCRIPT, id, "--steps", str(steps)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | dict.fromkeys(THREAD_VARIABLES, "1"),
    )
    if ended.returncode:
        lines = ended.stderr.strip().splitlines() or [f"exit code {ended.returncode}"]
        return {"environment": id, "reward": None, "steps_per_second": None, "error": lines[-1]}
    found: dict[str, Any] = json.loads(ended.stdout.splitlines()[-1])
    return found | {"error": None}


def _place(options: argparse.Namespace, id: str) -> Path:
    folder: Path = options.runs
    return folder / f"{id.rpartition('/')[2]}_{options.steps}.json"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("ids", nargs="*", metavar="ID", help="environments; without: each")
    parser.add_argument("--steps", type=int, default=1000, help="of training")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--runs", type=Path, required=True, help="folder of what is kept")
    parser.add_argument("--json", type=Path, help="file of the result; without: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
