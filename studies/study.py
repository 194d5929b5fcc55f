"""A study: a question, the commands that answer it, and the files that they write."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from string import Template

ROOT = Path(__file__).parents[1]
"""The checkout: every path of a study is relative to it."""
RESULTS = "studies/results"

DATA = {
    "kitti": "root of the KITTI object data, with stereo2012 and stereo2015 beside it",
    "scenarios": "the authors' labelled scenarios",
    "detections": "a detector's KITTI result files for them",
    "tracking": "root of the KITTI tracking data: `training`, with its labels and calibrations",
    "planning": "CommonRoad files and motion primitives, see benchmarks/report.py",
    "original": "a checkout of commonroad-search",
    "parity": "outputs of the original networks, see benchmarks/parity.py",
    "trainings": "runs of `avsec train`, each named as its network",
}
"""What a user gives, since it cannot be in the repository: option -> what it is."""


@dataclass(frozen=True)
class Step:
    """One Python process.

    ``$kitti`` and the like stand for what the user gives, ``$runs`` for the folder of runs.
    """

    words: tuple[str, ...]
    """The words behind ``python``: a script, or ``-m`` and a module, and the arguments."""
    to: str = ""
    """The file that standard output is written to; empty: it is shown."""

    @property
    def needs(self) -> set[str]:
        """The names of `DATA` that it takes."""
        return {name for word in self.words for name in re.findall(r"\$(\w+)", word)} & set(DATA)

    def filled(self, given: Mapping[str, list[str]]) -> Iterator[str]:
        """The words with what is given in its place; a name alone stands for all of its values."""
        first = {name: values[0] for name, values in given.items() if values}
        for word in self.words:
            if word.startswith("$") and word[1:] in given:
                yield from given[word[1:]]
            else:
                yield Template(word).substitute(first)


@dataclass(frozen=True)
class Study:
    """What one command makes anew."""

    name: str
    question: str
    minutes: int
    """What its steps take, about, on two cores; see `catalogue.minutes_of_command`."""
    writes: tuple[str, ...]
    """Files; the first one is what a reader opens."""
    steps: tuple[Step, ...]
    sources: tuple[str, ...]
    """Files and folders that it begins with: what they import belongs to its sources, too."""
    shows: tuple[str, ...] = ()
    """Studies whose results its page shows, too: they are made before it."""

    explained: tuple[str, ...] = ()
    """Pages of docs/ that are written by hand about its results."""

    @property
    def pages(self) -> list[str]:
        """The pages that stand on it: among what it writes, and those about it."""
        return [*(name for name in self.writes if name.endswith(".md")), *self.explained]

    @property
    def needs(self) -> list[str]:
        """The names of `DATA` without which it cannot be made, in their order."""
        asked = {name for step in self.steps for name in step.needs}
        return [name for name in DATA if name in asked]

    @property
    def command(self) -> str:
        """What makes it anew."""
        options = [f"--{name} DIR" for name in self.needs]
        return " ".join([f"python -m studies.{self.name}", *options])
