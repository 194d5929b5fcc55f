"""`avsec benchmark`: entries of the frozen benchmark."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import tyro

from avsec_gym import console
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.unknown_source import unknown_source

if TYPE_CHECKING:
    from avsec_gym.benchmark.entry import Entry, EntryRow
    from avsec_gym.metrics.clustered_shares import Share


@dataclass(frozen=True, kw_only=True)
class _Enter:
    """What all kinds of entries are asked."""

    kind: ClassVar[str]

    part: Annotated[str, tyro.conf.Positional]
    """The part by its name, a plug-in's too, or JSON with arguments."""
    out: Path
    """Folder of the entry: new, empty, or of the same entry, which goes on. entry.json is the
    result."""
    name: str | None = None
    """What the leaderboard calls it.  Default: the part's name."""
    quick: bool = False
    """A few scenes, to try: five minutes on two cores, and no row of a leaderboard."""
    workers: int | None = None
    """Number of processes, as of `avsec run`."""
    json: bool = False
    """Print the entry as JSON."""

    def run(self) -> int:
        """Do it; the exit code: 3 where scenes could not be driven."""
        from avsec_gym.benchmark.entry import ENTRY
        from avsec_gym.benchmark.making import entered
        from avsec_gym.benchmark.protocol import Entered

        with console.progress("driving") as shown:
            entry = entered(
                Entered(self.kind),
                self._part,
                self.out,
                name=self.name,
                quick=self.quick,
                error_models=self._error_models,
                labels=self._labels,
                workers=self.workers,
                on_progress=shown,
            )
        if self.json:
            console.print_json("benchmark.entry", entry.to_json())
        else:
            _print(entry)
            for scenes, reason in entry.skipped.items():
                console.say(f"avsec: {scenes} was left out: {reason}")
            left = ""
            if entry.failed:
                left = (
                    f", {entry.failed} scenes failed: run.log in the folders beside it states why,"
                    " and the same command tries them again"
                )
            console.say(f"{self.out / ENTRY}: version {entry.version}{left}")
        return console.DONE_IN_PART if entry.failed else console.DONE

    @property
    def _part(self) -> Any:
        from avsec_gym.commands.named_part import named_part

        return named_part(self.part, f"the {self.kind}")

    @property
    def _error_models(self) -> tuple[str, ...]:
        return ()

    @property
    def _labels(self) -> Path | None:
        return None


@dataclass(frozen=True, kw_only=True)
class _EnterByErrors(_Enter):
    """What stands in closed loop by its errors."""

    error_model: tuple[str, ...] = ()
    """Error models for the closed loop: files of `avsec error-model fit`, or names of shipped ones,
    without an attack and under attacks. Default: shipped ones that were fitted to it as it is, if
    there are any; without one the closed loop is left out."""

    @property
    def _error_models(self) -> tuple[str, ...]:
        return self.error_model


@dataclass(frozen=True, kw_only=True)
class BenchmarkDetector(_EnterByErrors):
    """Enter a detector: how a car drives by what it sees, unattacked and under attacks.

    Instead of a detector's name, a folder of its KITTI result files may be given:
    SCENES/SETTING/000000.txt, for the frames that `avsec benchmark frames` writes; or, beside
    --labels, its results on KITTI's own frames.
    """

    kind = "detector"

    labels: Path | None = None
    """Folder of the labelled scenarios (static_label, dynamic_label, ...), which the given results
    on KITTI's own frames are driven in and scored by; nothing of it is copied."""

    @property
    def _part(self) -> Any:
        from avsec_gym.registry import Kind, names
        from avsec_gym.storage.regular_files import is_folder

        part, known = super()._part, names(Kind.DETECTOR)
        if not isinstance(part, str) or part in known:
            return part
        if is_folder(Path(part)):
            return {"name": "replayed", "detections": str(Path(part).resolve())}
        expected = f"Name a folder of KITTI result files, or a detector. Known: {', '.join(known)}"
        raise unknown_source(part, known, expected, "detector named")

    @property
    def _labels(self) -> Path | None:
        return self.labels


@dataclass(frozen=True, kw_only=True)
class BenchmarkAttack(_EnterByErrors):
    """Enter an attack: what it costs the package's detectors, which it may know, and the drives."""

    kind = "attack"


@dataclass(frozen=True, kw_only=True)
class BenchmarkValidator(_Enter):
    """Enter a validator: its alarms under attack and without, and what they are worth.

    One of a single vehicle sees frames with light into a camera or the LiDAR, and the car drives.
    One of several vehicles, such as rays, sees instants of three, with a ghost in one scan or an
    object removed from it.
    """

    kind = "validator"


@dataclass(frozen=True, kw_only=True)
class BenchmarkPlanner(_Enter):
    """Enter a motion planner, which knows the truth; no image is rendered."""

    kind = "planner"


@dataclass(frozen=True)
class BenchmarkFrames:
    """Write the frames that a detector of another project looks at, in KITTI's object layout.

    OUT/SCENES/SETTING holds those of one set of scenes under one attack. What the detector sees in
    them, as KITTI result files RESULTS/SCENES/SETTING/000000.txt, is entered by `avsec benchmark
    detector RESULTS --out DIR`.
    """

    out: Path
    """Folder: new, empty, or of the same frames, which are gone on with."""
    quick: bool = False
    """Write only the frames of a quick entry."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.benchmark.frames import write_frames

        with console.progress("attacking") as shown:
            folders = write_frames(self.out, quick=self.quick, on_progress=shown)
        for folder in folders:
            console.say(str(folder))
        return console.DONE


@dataclass(frozen=True)
class BenchmarkBoard:
    """Write the leaderboard of entries as one HTML page."""

    entries: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """Files entry.json, or folders in which they are, at any depth."""
    out: Path = Path("leaderboard.html")
    """The page."""
    overwrite: bool = False
    """Write over the page if it is there."""

    def run(self) -> int:
        """Do it; the exit code: 3 where entries were left out."""
        from avsec_gym.benchmark.entry import read_entry
        from avsec_gym.benchmark.leaderboard import board, left_out
        from avsec_gym.benchmark.scene_sets import VERSION
        from avsec_gym.report.leaderboard_page import leaderboard_page
        from avsec_gym.storage.text_files import write_text

        kept, code = [], console.DONE
        files = self._files()
        for path in files:
            try:
                entry = read_entry(path)
                reason = left_out(entry)
            except DataError as error:
                if len(files) == 1:
                    raise
                reason = f"cannot be read: {error}"
            if reason:
                console.say(f"avsec: left out: {path} {reason}")
                code = console.DONE_IN_PART
            else:
                kept.append(entry)
        if not kept:
            raise DataError(
                "None of these entries is fit for the leaderboard.",
                path=self.entries[0],
                remedy="Make one with `avsec benchmark KIND NAME --out DIR`, without --quick.",
            )
        count = "1 entry" if len(kept) == 1 else f"{len(kept)} entries"
        page = leaderboard_page(board(kept), f"benchmark, version {VERSION}, {count}")
        write_text(self.out, page, overwrite=self.overwrite)
        console.say(f"{self.out}: {count}")
        return code

    def _files(self) -> list[Path]:
        """The files of all entries.

        Raises:
            ConfigurationError: None was named.
            DataError: There is none in a folder.
        """
        from avsec_gym.benchmark.entry import ENTRY
        from avsec_gym.storage.regular_files import is_folder

        if not self.entries:
            raise ConfigurationError("name entries: avsec benchmark board FILE_OR_FOLDER...")
        files = []
        for path in self.entries:
            found = sorted(path.rglob(ENTRY)) if is_folder(path) else [path]
            if not found:
                raise DataError(
                    f"There is no {ENTRY} in this folder.",
                    path=path,
                    remedy="Make an entry with `avsec benchmark KIND NAME --out DIR`.",
                )
            files += found
        return [*dict.fromkeys(path.resolve() for path in files)]


def _print(entry: Entry) -> None:
    """The tables of an entry."""
    if entry.rows:
        _print_queries(entry)
    if entry.instants:
        columns = ["instants", "alarms, %", "detected, %", "AUC", "victim, %", "another, %"]
        console.print_table(
            f"{entry.kind} {entry.name}, connected vehicles",
            ["setting", *columns],
            [
                [
                    row.setting,
                    str(row.instants),
                    *(_percent(share) for share in (row.alarms, row.detected)),
                    "" if row.area is None or row.area.value is None else f"{row.area.value:.3f}",
                    *(_percent(share) for share in (row.victim, row.another)),
                ]
                for row in entry.instants
            ],
        )
    if entry.drives:
        console.print_table(
            "in closed loop",
            ["setting", "at fault, %", "off road, %", "goal, %", "NAVSIM's score", "against"],
            [
                [
                    row.setting,
                    *(_percent(share) for share in (row.at_fault, row.off_road, row.goal)),
                    console.percent(row.navsim_score.value, _bounds(row.navsim_score.interval)),
                    row.against,
                ]
                for row in entry.drives
            ],
        )


def _print_queries(entry: Entry) -> None:
    columns = ["scenes", "setting", "safe, %", "collisions", "against", "safe, difference"]
    columns += ["AP 3D .7", "alarms, %", "stops"]
    rows = [_cells(row) for row in entry.rows]
    used = [i for i in range(len(columns)) if any(row[i] for row in rows)]
    console.print_table(
        f"{entry.kind} {entry.name}",
        [columns[i] for i in used],
        [[row[i] for i in used] for row in rows],
    )


def _percent(share: Share | None) -> str:
    return "" if share is None else console.percent(share.rate, _bounds(share.interval))


def _bounds(interval: Sequence[float] | None) -> list[float] | None:
    return None if interval is None else [*interval]


def _cells(row: EntryRow) -> list[str]:
    from avsec_gym.emergency_stop import STOPPED

    rates = row.rates.to_json()
    safe = console.percent(rates["safe_driving_rate"], rates["safe_driving_rate_interval"])
    difference = ""
    if row.paired is not None:
        own = row.paired.safe_driving_rate
        difference = console.percent(own.value, _bounds(own.interval))
    precision = ""
    if row.precision is not None and row.precision.strict.value is not None:
        precision = f"{row.precision.strict.value:.1f}"
    stops = row.rates.failures.get(STOPPED, 0)
    counts = [str(count) if count else "" for count in (row.rates.collisions, stops)]
    return [
        *(row.scenes, row.setting, safe, counts[0]),
        *(row.against, difference, precision, _percent(row.alarms), counts[1]),
    ]
