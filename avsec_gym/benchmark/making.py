"""Making an entry of the benchmark: a part drives the frozen scenes, in a folder that goes on."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from avsec_gym import __version__
from avsec_gym.attacks.attacked_detector import attack_kind
from avsec_gym.benchmark.adaptive_rows import AdaptiveRow
from avsec_gym.benchmark.connected_instants import InstantsRow
from avsec_gym.benchmark.entry import ENTRY, Entry, EntryRow, ScenesRow
from avsec_gym.benchmark.entry_sets import EntrySet, MeasuredRow, entry_sets
from avsec_gym.benchmark.loop_drives import DrivesRow
from avsec_gym.benchmark.protocol import (
    Entered,
    is_connected,
    is_replayed,
    is_white_box,
    places_in,
    settings_of,
    takes_gradients,
)
from avsec_gym.benchmark.query_rows import is_masked
from avsec_gym.benchmark.scene_sets import CONTESTED, VERSION, frozen_sets
from avsec_gym.perception.detectors.detector import network_name
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.progress import Progress, no_progress
from avsec_gym.registry import Kind, make
from avsec_gym.runs.fingerprints import fingerprint
from avsec_gym.runs.run import RunSummary, run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.export import world_fingerprint

_THREADS = 1


def entered(
    kind: Entered,
    part: Any,
    root: Path,
    *,
    name: str | None = None,
    quick: bool = False,
    error_models: Sequence[str] = (),
    labels: Path | None = None,
    workers: int | None = None,
    on_progress: Progress = no_progress,
) -> Entry:
    """Make an entry; what was done before in its folder is kept.

    Args:
        kind: What is entered.
        part: The part, as of `settings_of`.
        root: Folder of the entry; ``entry.json`` is its result.
        name: What it is called; None: as the part.
        quick: A few scenes only, in five minutes.
        error_models: What stands for a detector in closed loop, or for an attack on one: files of
            `avsec error-model fit`, or names of shipped ones.  None: the shipped ones, if there are
            any.
        labels: Folder of the labelled KITTI scenarios, where the part is a folder of results on
            KITTI's own frames; nothing of it is copied.
        workers: The number of processes, as of `run_experiments`; each has one thread, since the
            last digits of gradients depend on it.
        on_progress: Function that gets the number of scenes that are done and that of all.

    Raises:
        ConfigurationError: There is no such part, or this release makes other scenes.
        DataError: The folder holds something else, or results are missing.
    """
    sets = entry_sets(kind, part, quick=quick, error_models=error_models, labels=labels)
    kinds: tuple[type[MeasuredRow], ...] = (EntryRow, DrivesRow, InstantsRow, AdaptiveRow)
    found: dict[type[MeasuredRow], list[Any]] = {each: [] for each in kinds}
    scenes, failed, before, masked = [], 0, 0, False
    # Each set is a run of its own, kept in the entry's folder, and gives rows.
    for one_set in sets.driven:
        shown = partial(_progress, on_progress, before, sum(each.count for each in sets.driven))
        summary = _ran(one_set, root / one_set.name, workers, shown)
        before += summary.cells
        failed += len(summary.failures) + summary.failed_before
        run = RunFolder.open(root / one_set.name)
        for row in one_set.rows(run):
            found[type(row)].append(row)
        masked = masked or (one_set.name == CONTESTED and is_masked(run))
        scenes.append(ScenesRow(one_set.name, summary.cells, one_set.digest))
    # What made it: versions and sources of the last sitting.
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
        rows=found[EntryRow],
        drives=found[DrivesRow],
        instants=found[InstantsRow],
        adaptive=found[AdaptiveRow],
        skipped=sets.skipped,
        world=world_fingerprint() if kind.sees and labels is None else "",
        weights=_weights(kind, part) if labels is None else {},
        budget=_budget(kind, part),
        made_by={"avsec_gym": __version__, **made, "threads": _THREADS},
        failed=failed,
    )
    write_text(root / ENTRY, json.dumps(entry.to_json(), indent=1) + "\n", overwrite=True)
    return entry


def _ran(one_set: EntrySet, root: Path, workers: int | None, on_progress: Progress) -> RunSummary:
    """Do what is missing of a set's run, and once more what failed."""
    return run_experiments(
        [one_set.experiment],
        one_set.configuration,
        root,
        workers=workers,
        threads=_THREADS,
        retry=True,
        on_progress=on_progress,
    )


def _progress(on_progress: Progress, before: int, total: int, done: int, _: int) -> None:
    """That of one set among all."""
    on_progress(before + done, total)


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
    if kind == Entered.ATTACK:
        return takes_gradients(part)
    if kind != Entered.DETECTOR:
        return None
    return not is_replayed(part) and is_white_box(part)


def _weights(kind: Entered, part: Any) -> dict[str, str]:
    """Of all networks that drove or gave gradients, by name."""
    if is_connected(kind, part):
        return {}
    detectors: list[Any] = []
    for scenes in frozen_sets():
        for setting in settings_of(kind, part, scenes):
            parts = setting.parts or {}
            detectors += [parts.get("detector"), *_imitated(parts.get("attack"))]
    hashes = {}
    for detector in detectors:
        if detector is None or is_replayed(detector):
            continue
        made = make(Kind.DETECTOR, detector)
        name = network_name(made)
        if name not in hashes and (found := weights_hash(made)) is not None:
            hashes[name] = found
    return hashes


def _imitated(attack: Any) -> list[Any]:
    """The detectors whose gradients an attack takes in place of the victim's."""
    if not isinstance(attack, Mapping):
        return []
    inner = [each for own in attack.get("attacks", ()) for each in _imitated(own)]
    return [*([attack["of"]] if "of" in attack else []), *inner]


def _budget(kind: Entered, part: Any) -> dict[str, Any] | None:
    if kind != Entered.ATTACK:
        return None
    budget = getattr(make(attack_kind(part), part), "budget", None)
    return None if budget is None else asdict(budget)
