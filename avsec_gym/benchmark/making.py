"""Making an entry of the benchmark: a part drives the frozen scenes, in a folder that goes on."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from avsec_gym import __version__
from avsec_gym.attacks.attacked_detector import attack_kind
from avsec_gym.benchmark.entry import ENTRY, Entry, EntryRow, Precision, ScenesRow
from avsec_gym.benchmark.episodes import ALARM, BENCHMARK, ENTERED, NAMED
from avsec_gym.benchmark.protocol import (
    PATCH,
    TRANSFERRED,
    WHITE_BOX,
    Entered,
    Setting,
    is_replayed,
    is_white_box,
    places_in,
    settings_of,
)
from avsec_gym.benchmark.scene_sets import VERSION, FrozenSet, frozen_sets
from avsec_gym.errors import DataError
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, average_precision
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRates
from avsec_gym.perception.detectors.detector import network_name
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.registry import Kind, make
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.fingerprints import fingerprint
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.storage.regular_files import is_file
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.export.manifest import world_fingerprint

CATEGORY = "Car"
_RESAMPLES = 1000
_THREADS = 1


def entered(
    kind: Entered,
    part: Any,
    root: Path,
    *,
    name: str | None = None,
    quick: bool = False,
    workers: int | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> Entry:
    """Make an entry; what was done before in its folder is kept.

    Args:
        kind: What is entered.
        part: The part, as of `settings_of`.
        root: Folder of the entry; ``entry.json`` is its result.
        name: What it is called; None: as the part.
        quick: A few scenes only, in five minutes.
        workers: Processes, as of `run_experiments`; each has one thread, since the last digits of
            gradients depend on it.
        on_progress: Called with the number of scenes that are done and that of all.

    Raises:
        ConfigurationError: There is no such part, or this release makes other scenes.
        DataError: The folder holds something else, or results are missing.
    """
    rows: list[EntryRow] = []
    scenes, failed, before, masked = [], 0, 0, False
    for frozen in frozen_sets().values():  # A slip is reported before anything is made.
        frozen.check()
        for setting in settings_of(kind, part, frozen.name):
            _check_results(setting, frozen.ids(quick=quick))
    world = world_fingerprint() if kind.sees else ""
    counts = [frozen.count(images=kind.sees, quick=quick) for frozen in frozen_sets().values()]
    for frozen in frozen_sets().values():
        options = {"kind": str(kind), "part": part, "quick": quick, "world": world}
        configuration = Configuration(frozen.name, options=options)
        summary = run_experiments(
            [BENCHMARK],
            configuration,
            root / frozen.name,
            workers=workers,
            threads=_THREADS,
            retry=True,
            on_progress=partial(_progress, on_progress, before, sum(counts)),
        )
        before += summary.cells
        failed += len(summary.failures) + summary.failed_before
        run = RunFolder.open(root / frozen.name)
        rows += _rows(run, kind, part, frozen, quick=quick)
        masked = masked or (frozen.name == "contested" and _masked(run))
        scenes.append(ScenesRow(frozen.name, summary.cells, frozen.digest))
    last = run.manifest["sittings"][-1]
    made = {name: last[name] for name in ("versions", "sources", "python", "platform")}
    entry = Entry(
        version=VERSION,
        kind=kind,
        name=name or _name(part),
        part=_portable(part),
        quick=quick,
        white_box=_white_box(kind, part),
        masked=masked,
        scenes=scenes,
        rows=rows,
        world=world,
        weights=_weights(kind, part),
        budget=_budget(kind, part),
        made_by={"avsec_gym": __version__, **made, "threads": _THREADS},
        failed=failed,
    )
    write_text(root / ENTRY, json.dumps(entry.to_json(), indent=1) + "\n", overwrite=True)
    return entry


def _progress(
    on_progress: Callable[[int, int], None], before: int, total: int, done: int, _: int
) -> None:
    """That of one set among all."""
    on_progress(before + done, total)


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


def _masked(run: RunFolder) -> bool:
    """Whether an attack that does not know a detector is stronger than one by its gradients."""
    known = run.records(setting=WHITE_BOX, planner=ENTERED)
    for setting in (TRANSFERRED, PATCH) if known else ():
        paired = paired_differences(known, run.records(setting=setting, planner=ENTERED))
        interval = None if paired is None else paired.safe_driving_rate.interval
        if interval is not None and interval[1] < 0:
            return True
    return False


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
    if part["name"] == "defended":
        return str(make(Kind.DETECTOR, part).name)
    return Path(part["detections"]).name if is_replayed(part) else str(part["name"])


def _portable(part: Any) -> Any:
    """The part without a folder of this machine."""
    if is_replayed(part):
        return {"name": "replayed", "results": fingerprint(Path(part["detections"]))}
    if isinstance(part, Mapping):
        return {name: _portable(value) for name, value in part.items()}
    if isinstance(part, str) and (there := places_in(part)):
        return {"file": Path(part).name, "sha256": fingerprint(there[part])}
    return part


def _white_box(kind: Entered, part: Any) -> bool | None:
    if kind != Entered.DETECTOR:
        return None
    return not is_replayed(part) and is_white_box(part)


def _weights(kind: Entered, part: Any) -> dict[str, str]:
    """Of all networks that drove or gave gradients, by name."""
    detectors = []
    for setting in settings_of(kind, part, next(iter(frozen_sets()))):
        parts = setting.parts or {}
        attack = parts.get("attack")
        detectors += [parts.get("detector"), attack.get("of") if isinstance(attack, dict) else None]
    hashes = {}
    for detector in detectors:
        if detector is None or is_replayed(detector):
            continue
        made = make(Kind.DETECTOR, detector)
        name = network_name(made)
        if name not in hashes and (found := weights_hash(made)) is not None:
            hashes[name] = found
    return hashes


def _budget(kind: Entered, part: Any) -> dict[str, Any] | None:
    if kind != Entered.ATTACK:
        return None
    budget = getattr(make(attack_kind(part), part), "budget", None)
    return None if budget is None else asdict(budget)
