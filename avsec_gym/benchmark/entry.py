"""An entry of the benchmark: the rates of one part on the frozen scenes, as one JSON.

    {"schema": "avsec.benchmark.entry/1", "version": 1, "kind": "detector", "name": "dsgn", ...,
     "rows": [{"scenes": "contested", "setting": "white_box", "safe_driving_rate": 0.41, ...}],
     "drives": [{"setting": "patch", "at_fault": {"count": 31, "of": 120, ...}, ...}]}

`avsec_gym.benchmark.making` makes it; `read_entry` reads it, whoever made it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from avsec_gym.benchmark.adaptive_rows import AdaptiveRow
from avsec_gym.benchmark.connected_instants import InstantsRow
from avsec_gym.benchmark.loop_drives import DrivesRow
from avsec_gym.benchmark.protocol import Entered
from avsec_gym.errors import DataError
from avsec_gym.experiments.json_rows import OPTIONAL, row_json, row_of
from avsec_gym.json_schemas import SCHEMAS, with_schema
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.paired import PairedRates
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.storage.json_files import read_json_object

ENTRY = "entry.json"
"""The file in an entry's folder."""
SCHEMA = "benchmark.entry"


@dataclass(frozen=True)
class Precision:
    """How well cars are found: average precision of moderate ones, percent.

    Args:
        strict: The precision in 3D at an overlap of 0.7, 11 recall points, with its interval.
        strict_40: The same with 40 recall points.
        loose: The precision in 3D at an overlap of 0.5, 11 recall points.
        labels: Number of labels that count.
        ceiling: What perfect detections of so many labels reach, of `strict`.
    """

    strict: Estimate
    strict_40: Estimate
    loose: Estimate
    labels: int
    ceiling: float


@dataclass(frozen=True)
class EntryRow:
    """A setting on a set of scenes.

    Args:
        scenes: Name of the set.
        setting: Name of the setting, see `avsec_gym.benchmark.protocol`.
        rates: The three rates over its episodes.
        precision: Where something was detected.
        against: The setting that `paired` compares with.
        paired: Differences of the rates, this setting minus the other, on the same episodes.
        alarms: Frames with an alarm of a validator.
        named: Frames of which a validator named the attacked sensors, and no others.
        collided: Episodes that collide, of all of them.
        stopped: Episodes that the car stops in at an alarm, of all of them.
    """

    scenes: str
    setting: str
    rates: SafetyRates
    precision: Precision | None = field(default=None, metadata=OPTIONAL)
    against: str = ""
    paired: PairedRates | None = field(default=None, metadata=OPTIONAL)
    alarms: Share | None = field(default=None, metadata=OPTIONAL)
    named: Share | None = field(default=None, metadata=OPTIONAL)
    collided: Share | None = None
    stopped: Share | None = None


@dataclass(frozen=True)
class ScenesRow:
    """The scenes of an entry: name, number, and what they were frozen as."""

    scenes: str
    count: int
    digest: str


@dataclass(frozen=True)
class Entry:
    """A part and what became of the episodes with it.

    Args:
        version: The benchmark's version.
        kind: What was entered.
        name: What the leaderboard calls it.
        part: The part, by name or with its arguments; of results a fingerprint in place of their
            folder.
        quick: Whether only a few scenes were driven: no row of a leaderboard.
        white_box: Whether an attack took the detector's own gradients; of an attack, whether it
            takes those of the detector that it meets.  None: of other parts, and of an attack that
            is not known here.
        masked: Whether the attack by another detector's gradients left fewer contested episodes
            safe than that by its own in the same budget, the whole interval of the difference below
            0: then its gradients lead nowhere, and what seems robust under them is not.
        scenes: The scenes.
        rows: The results of single queries.
        drives: The results in closed loop.
        instants: The results of a validator of several vehicles.
        adaptive: What adaptive attacks do beyond the listed ones, to what defends.
        skipped: Sets that it was not driven in, by name, each with a sentence why.
        world: Fingerprint of the procedural world that rendered the scenes; empty without images.
        weights: SHA-256 of the weights of all networks that took part, by detector.
        budget: The most that an attack changes, grey levels, and of how many pixels; None of other
            parts.
        made_by: What the last sitting ran on: versions of the package and of the libraries, the
            machine, the threads of a process.
        failed: Scenes that could not be driven, whose episodes are missing.
    """

    version: int
    kind: Entered
    name: str
    part: Any
    quick: bool
    white_box: bool | None
    masked: bool
    scenes: Sequence[ScenesRow]
    rows: Sequence[EntryRow]
    world: str
    weights: Mapping[str, str]
    budget: Mapping[str, Any] | None
    made_by: Mapping[str, Any]
    drives: Sequence[DrivesRow] = ()
    instants: Sequence[InstantsRow] = ()
    adaptive: Sequence[AdaptiveRow] = ()
    skipped: Mapping[str, str] = field(default_factory=dict)
    failed: int = 0

    @property
    def broken(self) -> bool | None:
        """Whether an adaptive attack breaks it; None: none was tried."""
        return any(row.breaks for row in self.adaptive) if self.adaptive else None

    def row(self, scenes: str, setting: str) -> EntryRow | None:
        """The row of a setting on a set of scenes."""
        found = (row for row in self.rows if (row.scenes, row.setting) == (scenes, setting))
        return next(found, None)

    def drive(self, setting: str) -> DrivesRow | None:
        """The row of a setting in closed loop."""
        return next((row for row in self.drives if row.setting == setting), None)

    def instant(self, setting: str) -> InstantsRow | None:
        """The row of a state of the connected vehicles."""
        return next((row for row in self.instants if row.setting == setting), None)

    def to_json(self) -> dict[str, Any]:
        """All of it, with its schema."""
        return with_schema(SCHEMA, row_json(self))


def read_entry(path: Path) -> Entry:
    """An entry's file.

    Raises:
        DataError: It is none, or one of another form.
    """
    remedy = "Make it with `avsec benchmark`; entry.json is in the folder --out."
    found = read_json_object(path, remedy=remedy)
    schema = f"avsec.{SCHEMA}/{SCHEMAS[SCHEMA]}"
    if found.get("schema") != schema:
        problem = f"This is no entry of the benchmark: its schema is not {schema}."
        raise DataError(problem, path=path, remedy=remedy)
    try:
        return row_of(Entry, found)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        problem = f"This entry of the benchmark is damaged ({error})."
        raise DataError(problem, path=path, remedy=remedy) from error
