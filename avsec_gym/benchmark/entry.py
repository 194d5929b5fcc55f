"""An entry of the benchmark: the rates of one part on the frozen scenes, as one JSON.

    {"schema": "avsec.benchmark.entry/1", "version": 1, "kind": "detector", "name": "dsgn", ...,
     "rows": [{"scenes": "contested", "setting": "white_box", "safe_driving_rate": 0.41, ...}]}

`entered` makes it, in a folder that can be gone on with; `read_entry` reads anybody's.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from avsec_gym import __version__
from avsec_gym.benchmark.episodes import ALARM, BENCHMARK, ENTERED, NAMED
from avsec_gym.benchmark.protocol import (
    TRANSFERRED,
    WHITE_BOX,
    Entered,
    Setting,
    is_replayed,
    is_white_box,
    settings_of,
)
from avsec_gym.benchmark.scene_sets import VERSION, FrozenSet, frozen_sets
from avsec_gym.errors import DataError
from avsec_gym.experiments.json_rows import OPTIONAL, row_json, row_of
from avsec_gym.json_schemas import SCHEMAS, with_schema
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, average_precision
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.paired import PairedRates, paired_differences
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.registry import Kind, make
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.fingerprints import environment, fingerprint
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.export.manifest import world_fingerprint

ENTRY = "entry.json"
"""In an entry's folder."""
CATEGORY = "Car"
_RESAMPLES = 1000
_SCHEMA = "benchmark.entry"


@dataclass(frozen=True)
class Precision:
    """How well cars are found: average precision of moderate ones, percent.

    Args:
        strict: In 3D at an overlap of 0.7, 11 recall points, with its interval.
        strict_40: The same with 40 recall points.
        loose: In 3D at an overlap of 0.5, 11 recall points.
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
        alarms: Of a validator: frames with an alarm.
        named: Of a validator: frames of which it named the attacked sensors, and no others.
    """

    scenes: str
    setting: str
    rates: SafetyRates
    precision: Precision | None = field(default=None, metadata=OPTIONAL)
    against: str = ""
    paired: PairedRates | None = field(default=None, metadata=OPTIONAL)
    alarms: Share | None = field(default=None, metadata=OPTIONAL)
    named: Share | None = field(default=None, metadata=OPTIONAL)


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
        white_box: Of a detector: whether an attack took its own gradients.
        broken: Of a detector: whether that attack made fewer contested drives safe than one that
            took another detector's gradients, the whole interval of the difference below 0; what
            seems robust there only hides its gradients from who does not ask for them.
        scenes: The scenes.
        rows: The results.
        world: Fingerprint of the procedural world that rendered the scenes; empty without images.
        weights: SHA-256 of the weights of the part's network, if it has one.
        made_by: Versions of the package and of the libraries, and the machine.
        failed: Scenes that could not be driven, whose episodes are missing.
    """

    version: int
    kind: Entered
    name: str
    part: Any
    quick: bool
    white_box: bool | None
    broken: bool
    scenes: Sequence[ScenesRow]
    rows: Sequence[EntryRow]
    world: str
    weights: str | None
    made_by: Mapping[str, Any]
    failed: int = 0

    def row(self, scenes: str, setting: str) -> EntryRow | None:
        """The row of a setting on a set of scenes."""
        found = (row for row in self.rows if (row.scenes, row.setting) == (scenes, setting))
        return next(found, None)

    def to_json(self) -> dict[str, Any]:
        """All of it, with its schema."""
        return with_schema(_SCHEMA, row_json(self))


def entered(
    kind: Entered,
    part: Any,
    root: Path,
    *,
    name: str | None = None,
    quick: bool = False,
    workers: int | None = None,
    threads: int | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> Entry:
    """Make an entry; what was done before in its folder is kept.

    Args:
        kind: What is entered.
        part: The part, as of `settings_of`.
        root: Folder of the entry; ``entry.json`` is its result.
        name: What it is called; None: as the part.
        quick: A few scenes only, in five minutes.
        workers: Processes, as of `run_experiments`.
        threads: Threads of each, likewise.
        on_progress: Called with the number of scenes that are done and that of all.

    Raises:
        ConfigurationError: There is no such part, or this release makes other scenes.
        DataError: The folder holds something else, or results are missing.
    """
    rows: list[EntryRow] = []
    scenes, failed, before, broken = [], 0, 0, False
    for frozen in frozen_sets().values():  # A slip is reported before anything is made.
        settings_of(kind, part, frozen.name)
    counts = [frozen.count(images=kind.sees, quick=quick) for frozen in frozen_sets().values()]
    for frozen in frozen_sets().values():
        frozen.check()
        configuration = Configuration(
            frozen.name, options={"kind": str(kind), "part": part, "quick": quick}
        )
        summary = run_experiments(
            [BENCHMARK],
            configuration,
            root / frozen.name,
            workers=workers,
            threads=threads,
            on_progress=partial(_progress, on_progress, before, sum(counts)),
        )
        before += summary.cells
        failed += len(summary.failures) + summary.failed_before
        run = RunFolder.open(root / frozen.name)
        rows += _rows(run, kind, part, frozen, quick=quick)
        broken = broken or (frozen.name == "contested" and _broken(run))
        scenes.append(ScenesRow(frozen.name, summary.cells, frozen.digest))
    made: Mapping[str, Any] = environment()
    entry = Entry(
        version=VERSION,
        kind=kind,
        name=name or _name(part),
        part=_portable(part),
        quick=quick,
        white_box=_white_box(kind, part),
        broken=broken,
        scenes=scenes,
        rows=rows,
        world=world_fingerprint() if kind.sees else "",
        weights=_weights(kind, part),
        made_by={"avsec_gym": __version__, **made},
        failed=failed,
    )
    write_text(root / ENTRY, json.dumps(entry.to_json(), indent=1) + "\n", overwrite=True)
    return entry


def _progress(
    on_progress: Callable[[int, int], None], before: int, total: int, done: int, _: int
) -> None:
    """That of one set among all."""
    on_progress(before + done, total)


def read_entry(path: Path) -> Entry:
    """An entry's file.

    Raises:
        DataError: It is none, or one of another form.
    """
    remedy = "Make it with `avsec benchmark`; entry.json is in the folder --out."
    found = read_json_object(path, remedy=remedy)
    schema = f"avsec.{_SCHEMA}/{SCHEMAS[_SCHEMA]}"
    if found.get("schema") != schema:
        problem = f"This is no entry of the benchmark: its schema is not {schema}."
        raise DataError(problem, path=path, remedy=remedy)
    try:
        return row_of(Entry, found)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        problem = f"This entry of the benchmark is damaged ({error})."
        raise DataError(problem, path=path, remedy=remedy) from error


def _rows(
    run: RunFolder, kind: Entered, part: Any, frozen: FrozenSet, *, quick: bool
) -> Iterator[EntryRow]:
    """The rows of one set of scenes."""
    truth = {}
    if kind.sees:
        frames = frozen.frames(quick=quick)
        truth = {scene.id: frames.labels(scene) for scene in frames.scenes.labelled}
    for setting in settings_of(kind, part, frozen.name):
        records = run.records(setting=setting.name, planner=ENTERED)
        before = run.records(setting=setting.against, planner=ENTERED) if setting.against else None
        yield EntryRow(
            scenes=frozen.name,
            setting=setting.name,
            rates=SafetyRates.of(records),
            precision=_precision(run, setting, truth),
            against=setting.against,
            paired=paired_differences(before, records) if before else None,
            alarms=_share(run, setting, ALARM),
            named=_share(run, setting, NAMED),
        )


def _broken(run: RunFolder) -> bool:
    """Whether an adaptive attack on a detector is stronger than a transferred one."""
    known, unknown = (
        run.records(setting=setting, planner=ENTERED) for setting in (WHITE_BOX, TRANSFERRED)
    )
    if not known or not unknown:
        return False
    paired = paired_differences(unknown, known)
    interval = None if paired is None else paired.safe_driving_rate.interval
    return interval is not None and interval[1] < 0


def _precision(run: RunFolder, setting: Setting, truth: Mapping[str, Any]) -> Precision | None:
    found = run.detections(setting.name)
    if not found:
        return None
    # Frames whose cell failed are missing on both sides.
    labels, boxes = [truth[id] for id in found], [*found.values()]
    strict = average_precision(
        labels, boxes, classes=[CATEGORY], min_iou=STANDARD_IOU, resamples=_RESAMPLES
    )
    loose = average_precision(
        labels, boxes, classes=[CATEGORY], min_iou=LOW_IOU, resamples=_RESAMPLES
    )
    return Precision(
        strict=_moderate(strict.to_json(), "ap11"),
        strict_40=_moderate(strict.to_json(), "ap40"),
        loose=_moderate(loose.to_json(), "ap11"),
        labels=int(strict.labels[0, _MODERATE]),
        ceiling=float(strict.ceiling[0, _MODERATE, 0]),
    )


_MODERATE = 1


def _moderate(found: Mapping[str, Any], figure: str) -> Estimate:
    """One figure of moderate cars in 3D."""
    of = found[CATEGORY]["3d"]
    return Estimate(of[figure][_MODERATE], of[f"{figure}_interval"][_MODERATE])


def _share(run: RunFolder, setting: Setting, name: str) -> Share | None:
    """A share of frames, each a scene of its own."""
    rows = run.measurements(name=name, setting=setting.name)
    if not rows:
        return None
    return share_of([row["value"] > 0 for row in rows], [row["scenario"] for row in rows])


def _name(part: Any) -> str:
    if isinstance(part, str):
        return part
    return Path(part["detections"]).name if is_replayed(part) else str(part["name"])


def _portable(part: Any) -> Any:
    """The part without a folder of this machine."""
    if not is_replayed(part):
        return part
    return {"name": "replayed", "results": fingerprint(Path(part["detections"]))}


def _white_box(kind: Entered, part: Any) -> bool | None:
    if kind != Entered.DETECTOR:
        return None
    return not is_replayed(part) and is_white_box(part)


def _weights(kind: Entered, part: Any) -> str | None:
    if kind != Entered.DETECTOR or is_replayed(part):
        return None
    return weights_hash(make(Kind.DETECTOR, part))
