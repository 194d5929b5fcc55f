"""Facts of a run itself: what was asked, what is done, what failed, how long it took."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any

from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.runs.manifest import Manifest, Sitting
from avsec_gym.runs.run_folder import RunFolder


class NamedManifest(Manifest):
    """The manifest, and the name of the folder that it is in."""

    folder: str


@dataclass(frozen=True)
class CellCounts:
    """How many cells there are of each status."""

    done: int
    failed: int
    missing: int


@dataclass(frozen=True)
class FailedCells:
    """Cells that failed for one reason.

    Args:
        error: The reason.
        cells: How many they are.
        example: The arguments of one of them.
    """

    error: str
    cells: int
    example: Mapping[str, Any]


@dataclass(frozen=True)
class CellTimes:
    """How many cells took how long, all together."""

    cells: int
    seconds: float


@dataclass(frozen=True)
class Timings:
    """Where the time went.

    Args:
        parts: Times by part of the work.
        attacks: Times by attack, in the order of tables.
        wall: Seconds of all sittings that were not cut short.
    """

    parts: Mapping[str, CellTimes]
    attacks: Mapping[str, CellTimes]
    wall: float


@dataclass(frozen=True)
class RunFacts:
    """What is known of every run.

    Args:
        question: The question that the run answers.
        manifest: What was asked.
        cells: What is done.
        failures: What failed, the most frequent reason first.
        timings: How long it took.
    """

    question: str
    manifest: NamedManifest
    cells: CellCounts
    failures: Sequence[FailedCells]
    timings: Timings

    def to_json(self) -> dict[str, Any]:
        """All of it, as JSON."""
        return asdict(self)


@dataclass(frozen=True)
class OtherRates:
    """Rates under a setting that no experiment reports."""

    setting: str
    strength: float
    rates: SafetyRates

    def to_json(self) -> dict[str, Any]:
        """All of it, the columns of the rates among its own."""
        return {"setting": self.setting, "strength": self.strength, **self.rates.to_json()}


def run_facts(run: RunFolder, question: str, known: Sequence[str]) -> RunFacts:
    """The facts of a run, finished or not.

    Args:
        run: The run.
        question: The question that it answers.
        known: Attacks in the order of tables; others come after them.
    """
    cells, manifest = run.cells(), run.manifest
    failures = [cell for cell in cells if cell.failed]
    attacks: dict[str, list[float]] = {}
    for cell in cells:
        if not cell.failed and "attack" in cell.arguments:
            attacks.setdefault(cell.arguments["attack"], []).append(cell.seconds)
    counts = Counter(str(cell.error) for cell in failures)
    examples = {str(cell.error): cell.arguments for cell in reversed(failures)}
    places = {attack: place for place, attack in enumerate(known)}
    return RunFacts(
        question,
        {**manifest, "folder": run.path.resolve().name},
        CellCounts(len(cells) - len(failures), len(failures), run.missing()),
        [FailedCells(error, count, examples[error]) for error, count in counts.most_common()],
        Timings(
            {
                part: CellTimes(int(times["cells"]), times["seconds"])
                for part, times in run.timings().items()
            },
            {
                name: CellTimes(len(attacks[name]), sum(attacks[name]))
                for name in sorted(attacks, key=lambda one: (places.get(one, len(places)), one))
            },
            sum(_seconds(sitting) for sitting in manifest["sittings"]),
        ),
    )


def other_rates(run: RunFolder, reported: Collection[str]) -> list[OtherRates]:
    """Rates under settings that no experiment reports.

    Args:
        run: The run.
        reported: Settings that an experiment reports.
    """
    return [
        OtherRates(name, strength, SafetyRates.of(run.records(setting=name, strength=strength)))
        for name, strength in run.settings()
        if name not in reported and run.episodes(setting=name, strength=strength)
    ]


def _seconds(sitting: Sitting) -> float:
    """0 while it goes on, or where it was killed."""
    if sitting["ended"] is None:
        return 0.0
    begun, ended = map(datetime.fromisoformat, (sitting["started"], sitting["ended"]))
    return (ended - begun).total_seconds()
