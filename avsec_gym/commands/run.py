"""`avsec run`: tables and figures of the thesis, in as many sittings as it takes."""

from __future__ import annotations

import json
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from avsec_gym import console
from avsec_gym.errors import ConfigurationError
from avsec_gym.progress import Progress, no_progress
from avsec_gym.storage.json_files import parse_json

if TYPE_CHECKING:
    from avsec_gym.runs.run import RunSummary

_REMARKS = 10
"""So many failed cells are reported one by one."""


@dataclass(frozen=True)
class Run:
    """Run experiments; `avsec experiments` lists them.

    A run that was stopped, or killed, goes on where it was when the command is given again. What
    several experiments need is done once. `avsec report` shows what came out.
    """

    names: Annotated[tuple[str, ...], tyro.conf.Positional]
    """Which ones, those of plug-ins too; any other is named by its place,
    my_package.my_module:MY_EXPERIMENT."""
    scenarios: str | None = None
    """Which scenes: a folder in KITTI's object layout; a default suite of the procedural world
    (mixed, street, highway), made on first use; or `procedural`: --limit scenes of that world (12),
    drawn from the seed.  Default: what the first experiment is usually about, mixed for
    most."""
    limit: int | None = None
    """Only the first scenes."""
    seed: int = 0
    """Seed of everything that is drawn."""
    options: tuple[str, ...] = ()
    """Options of the experiments, NAME=VALUE each; `avsec experiments --json` lists names and
    defaults. Values are JSON; what is no JSON is a text."""
    detector: str | None = None
    """Detector of experiments that take any parts, such as `pipeline`: a part by its name, one of a
    plug-in's too, or JSON with arguments; the same as --options detector=..."""
    attack: str | None = None
    """An attack, likewise, such as '{"name": "facula", "camera": 2}'."""
    planner: str | None = None
    """A planner, likewise."""
    validator: str | None = None
    """A validator, likewise; it sits before the detector."""
    out: Path | None = None
    """Folder of the run: new, empty, or with the same run.  Default: runs/NAMES."""
    workers: int | None = None
    """Number of processes.  Default: as many as have cores for their threads, up to four on each
    machine. 0: this very process."""
    threads: int | None = None
    """Threads of each process; the last digits of networks depend on it. Default: what the run
    began with, or the cores divided by the processes."""
    backend: Literal["local", "ray"] = "local"
    """Where the processes are: on this machine, or in the Ray cluster of RAY_ADDRESS, else in one
    begun for the while (extra `distributed`)."""
    retry: bool = False
    """Do failed cells again."""
    json: bool = False
    """Print a summary as JSON."""

    def run(self) -> int:
        """Do it; the exit code: 3 where cells failed."""
        return self.ran(no_progress)

    def ran(self, on_progress: Progress, besides: Collection[str] = ()) -> int:
        """Do it; the exit code.

        Args:
            on_progress: Function of the progress, called beside what the user is shown.
            besides: Names of files that may be in a new folder, as of `run_experiments`.
        """
        from avsec_gym.runs.catalogue import experiment
        from avsec_gym.runs.experiment import Configuration
        from avsec_gym.runs.run import Backend, run_experiments

        if not self.names:
            raise ConfigurationError("name an experiment; `avsec experiments` lists them")
        experiments = [experiment(name) for name in dict.fromkeys(self.names)]
        usual = experiments[0].usual
        configuration = Configuration(
            self.scenarios or usual.scenarios,
            self.limit if self.scenarios or self.limit is not None else usual.limit,
            self.seed,
            {**dict(map(_option, self.options)), **self._parts},
        )
        default = Path("runs") / "+".join(each.name for each in experiments)
        with console.progress("running") as shown:
            report = run_experiments(
                experiments,
                configuration,
                self.out or default,
                workers=self.workers,
                threads=self.threads,
                backend=Backend(self.backend),
                retry=self.retry,
                on_progress=_both(shown, on_progress),
                besides=besides,
            )
        for cell, error in report.failures[:_REMARKS]:
            console.say(f"avsec: failed: {cell.key}: {error}")
        if len(report.failures) > _REMARKS:
            console.say(f"avsec: failed: {len(report.failures) - _REMARKS} more cells")
        if self.json:
            console.print_json("run", _summary(report))
        else:
            console.say(_sentence(report))
        return console.DONE_IN_PART if report.failures or report.failed_before else console.DONE

    @property
    def _parts(self) -> dict[str, Any]:
        from avsec_gym.commands.named_part import named_part

        return {
            name: named_part(text, f"--{name}")
            for name in ("detector", "attack", "planner", "validator")
            if (text := getattr(self, name)) is not None
        }


def _both(one: Progress, other: Progress) -> Progress:
    def on_progress(done: int, total: int) -> None:
        one(done, total)
        other(done, total)

    return on_progress


def _option(text: str) -> tuple[str, Any]:
    name, sign, value = text.partition("=")
    if not sign or not name:
        raise ConfigurationError(f"--options takes NAME=VALUE, got {text!r}")
    try:
        return name, parse_json(value)
    except json.JSONDecodeError:
        return name, value
    except ValueError as error:
        raise ConfigurationError(f"--options {name} cannot be taken: {error}") from None


def _summary(report: RunSummary) -> dict[str, Any]:
    return {
        "out": str(report.root),
        "cells": report.cells,
        "kept": report.kept,
        "done": report.done,
        "failed": len(report.failures),
        "failed_before": report.failed_before,
        "failures": [
            {"work": cell.work, "arguments": cell.arguments, "error": error}
            for cell, error in report.failures
        ],
    }


def _sentence(report: RunSummary) -> str:
    text = f"{report.root}: {report.cells} cells, {report.done} done, {report.kept} were there"
    failed = len(report.failures) + report.failed_before
    if failed:
        text += f", {failed} failed; run.log states why, --retry does them again"
    return text
