"""The frozen sets that an entry is driven in: those that make sense for its kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from avsec_gym.benchmark.adaptive_rows import AdaptiveRow, detector_rows, validator_rows
from avsec_gym.benchmark.connected_instants import (
    BENCHMARK_INSTANTS,
    InstantsRow,
    instants_adaptive_rows,
    instants_rows,
)
from avsec_gym.benchmark.connected_scenes import CONNECTED, frozen_instants
from avsec_gym.benchmark.entry import EntryRow
from avsec_gym.benchmark.episodes import BENCHMARK
from avsec_gym.benchmark.kitti_results import BENCHMARK_KITTI, check_kitti, kitti_rows
from avsec_gym.benchmark.kitti_scenes import KITTI, frozen_labels
from avsec_gym.benchmark.loop_drives import BENCHMARK_DRIVES, DrivesRow, drives_rows
from avsec_gym.benchmark.loop_protocol import NoErrorModel, loop_settings
from avsec_gym.benchmark.loop_scenes import CLOSED_LOOP, frozen_drives
from avsec_gym.benchmark.protocol import (
    Entered,
    Setting,
    is_connected,
    is_replayed,
    results_of,
    settings_of,
)
from avsec_gym.benchmark.query_rows import query_rows
from avsec_gym.benchmark.scene_sets import CONTESTED, frozen_sets
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.registry import Kind, check
from avsec_gym.runs.experiment import Configuration, Experiment
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.storage.regular_files import is_file
from avsec_gym.world.export import world_fingerprint

_OF_KITTI = (
    "these are results on KITTI's own frames: enter those on the frames of `avsec benchmark frames`"
    " beside it, without --labels"
)
MeasuredRow = EntryRow | DrivesRow | InstantsRow | AdaptiveRow


@dataclass(frozen=True)
class EntrySet:
    """A frozen set that an entry is driven in.

    Args:
        experiment: What is done in its scenes.
        configuration: The scenes by the set's name, and what is entered.
        count: The number of scenes.
        digest: What they were frozen as.
        rows: Function that makes the rows of an entry of a run.
    """

    experiment: Experiment
    configuration: Configuration
    count: int
    digest: str
    rows: Callable[[RunFolder], Sequence[MeasuredRow]]

    @property
    def name(self) -> str:
        """The name of the set."""
        return self.configuration.scenarios


@dataclass(frozen=True)
class EntrySets:
    """The sets of an entry.

    Args:
        driven: The sets that it is driven in.
        skipped: The sets that it is not driven in, by name, each with a sentence why and what to
            do.
    """

    driven: Sequence[EntrySet]
    skipped: Mapping[str, str] = field(default_factory=dict)


def entry_sets(
    kind: Entered,
    part: Any,
    *,
    quick: bool = False,
    error_models: Sequence[str] = (),
    labels: Path | None = None,
) -> EntrySets:
    """The sets of an entry; slips in what was entered are reported before anything is made.

    Args:
        kind: What is entered.
        part: The part, as of `avsec_gym.benchmark.protocol.settings_of`.
        quick: Whether a few scenes only are driven.
        error_models: Error models, as of `avsec_gym.benchmark.loop_protocol.loop_settings`.
        labels: Folder of the labelled KITTI scenarios, which results of a detector are of; None:
            they are of the benchmark's own frames.

    Raises:
        ConfigurationError: There is no such part, this release makes other scenes, or what is not
            known by its results is entered with labels.
        DataError: Results are missing, or the labels are not the frozen ones.
    """
    if labels is not None:
        if kind != Entered.DETECTOR or not is_replayed(part) or quick or error_models:
            raise ConfigurationError(
                "--labels: a detector's folder of KITTI result files is entered with labels, whole,"
                " and without error models"
            )
        return _kitti(results_of(part), labels)
    if is_connected(kind, part):
        return EntrySets([_connected(part, quick)])
    driven, skipped = _queries(kind, part, quick), {}
    if kind == Entered.VALIDATOR:  # It compares the sensors of one vehicle.
        return EntrySets(driven)
    try:
        driven.append(_closed_loop(kind, part, quick, [*error_models]))
    except NoErrorModel as reason:
        skipped[CLOSED_LOOP] = str(reason)
    return EntrySets(driven, skipped)


def _kitti(results: Path, labels: Path) -> EntrySets:
    """The labelled KITTI scenarios, and nothing else: results are of their frames."""
    check_kitti(labels, results)
    frozen = frozen_labels()
    options = {"labels": str(labels.resolve()), "detections": str(results)}
    one_set = EntrySet(
        BENCHMARK_KITTI,
        Configuration(KITTI, options=options),
        len(frozen.scenes(labels)),
        frozen.digest,
        partial(kitti_rows, labels=labels),
    )
    return EntrySets([one_set], dict.fromkeys((*frozen_sets(), CLOSED_LOOP), _OF_KITTI))


def _queries(kind: Entered, part: Any, quick: bool) -> list[EntrySet]:
    """Single queries."""
    options = {"kind": str(kind), "part": part, "quick": quick}
    options["world"] = world_fingerprint() if kind.sees else ""
    sets = []
    for name, frozen in frozen_sets().items():
        for setting in settings_of(kind, part, name):
            _check_results(setting, frozen.ids(quick=quick))
        frozen.check()
        rows = partial(_query_rows, kind=kind, part=part, name=name, quick=quick)
        count = frozen.count(images=kind.sees, quick=quick)
        configuration = Configuration(name, options=options)
        sets.append(EntrySet(BENCHMARK, configuration, count, frozen.digest, rows))
    return sets


def _query_rows(
    run: RunFolder, *, kind: Entered, part: Any, name: str, quick: bool
) -> Sequence[MeasuredRow]:
    rows: list[MeasuredRow] = [*query_rows(run, kind, part, frozen_sets()[name], quick=quick)]
    if name == CONTESTED:
        rows += detector_rows(run) if kind == Entered.DETECTOR else validator_rows(run)
    return rows


def _closed_loop(kind: Entered, part: Any, quick: bool, models: Sequence[str]) -> EntrySet:
    """Drives in closed loop.

    Raises:
        NoErrorModel: Nothing stands for the part there.
    """
    settings, frozen = loop_settings(kind, part, models), frozen_drives()
    frozen.check(quick=quick)
    options = {"kind": str(kind), "part": part, "quick": quick, "error_models": [*models]}
    return EntrySet(
        BENCHMARK_DRIVES,
        Configuration(CLOSED_LOOP, options=options),
        len(frozen.ids(quick=quick)),
        frozen.digest,
        partial(drives_rows, settings=settings),
    )


def _connected(part: Any, quick: bool) -> EntrySet:
    """Instants of connected vehicles."""
    check(Kind.CONNECTED_VALIDATOR, part)
    frozen = frozen_instants()
    options = {"part": part, "quick": quick, "world": world_fingerprint()}
    return EntrySet(
        BENCHMARK_INSTANTS,
        Configuration(CONNECTED, options=options),
        len(frozen.numbers(quick=quick)),
        frozen.digest,
        lambda run: [*instants_rows(run), *instants_adaptive_rows(run)],
    )


def _check_results(setting: Setting, ids: Sequence[str]) -> None:
    """Refuse results that are not there for every frame.

    Raises:
        DataError: A file is missing; one in which nothing was found is empty.
    """
    detector = (setting.parts or {}).get("detector", {})
    if not is_replayed(detector):
        return
    folder = Path(detector["detections"])
    missing = [id for id in ids if not is_file(folder / f"{id}.txt")]
    if missing:
        raise DataError(
            f"{len(missing)} of {len(ids)} result files are not here, the first {missing[0]}.txt.",
            path=folder,
            remedy="Write a file for every frame, an empty one where nothing was found.",
        )
