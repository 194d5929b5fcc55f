"""`avsec experiments`: what `avsec run` can run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import tyro

from avsec_gym import console


@dataclass(frozen=True)
class Experiments:
    """List the experiments: the question of each, its place in the thesis, its size."""

    names: Annotated[tuple[str, ...], tyro.conf.Positional] = ()
    """Which ones.  Default: all."""
    scenarios: str | None = None
    """Count the cells that `avsec run` would do for these scenes.  Without it they are not
    counted: the default scenes may have to be made first."""
    limit: int | None = None
    """Only the first scenes."""
    json: bool = False
    """Print JSON, with options and their defaults."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.runs.catalogue import experiment, importable_experiments

        problems: list[str] = []
        if self.names:
            found = [experiment(name) for name in self.names]
        else:
            found, problems = importable_experiments()
        for problem in problems:
            console.say(f"avsec: {problem}")
        listed: list[dict[str, Any]] = [
            {
                "name": each.name,
                "question": each.question,
                "thesis": each.thesis,
                "cells": self._count(each),
                "options": dict(each.options),
            }
            for each in found
        ]
        if self.json:
            console.print_json("experiments", {"experiments": listed})
            return console.DONE
        console.print_table(
            "what `avsec run` can run",
            ["name", "thesis", "question", "cells"],
            [
                [
                    row["name"],
                    row["thesis"] or "beyond it",
                    row["question"],
                    "–" if row["cells"] is None else str(row["cells"]),
                ]
                for row in listed
            ],
        )
        return console.DONE

    def _count(self, experiment: Any) -> int | None:
        from avsec_gym.runs.experiment import Configuration, with_defaults

        if self.scenarios is None:
            return None
        asked = with_defaults(Configuration(self.scenarios, self.limit), [experiment])
        return len(set(experiment.cells(asked)))
