"""The rows of single queries: rates, precision and alarms of every setting on one frozen set."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from avsec_gym.benchmark.entry import EntryRow, Precision
from avsec_gym.benchmark.episodes import ALARM, ENTERED, NAMED
from avsec_gym.benchmark.protocol import (
    TRANSFERRED,
    WHITE_BOX,
    Entered,
    Setting,
    settings_of,
)
from avsec_gym.benchmark.scene_sets import FrozenSet
from avsec_gym.boxes import Boxes3D
from avsec_gym.emergency_stop import STOPPED
from avsec_gym.metrics.average_precision import LOW_IOU, STANDARD_IOU, average_precision
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.runs.run_folder import RunFolder

CATEGORY = "Car"
_RESAMPLES = 1000


def query_rows(
    run: RunFolder, kind: Entered, part: Any, frozen: FrozenSet, *, quick: bool
) -> Iterator[EntryRow]:
    """The rows of one set of scenes.

    Args:
        run: A run of `avsec_gym.benchmark.episodes.BENCHMARK` on the set.
        kind: What is entered.
        part: The part.
        frozen: The set.
        quick: Whether only the scenes of a quick entry were driven.
    """
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
            collided=share_of_episodes(records, [record.collision for record in records]),
            stopped=share_of_episodes(records, [record.reason == STOPPED for record in records]),
        )


def is_masked(run: RunFolder) -> bool:
    """Whether another detector's gradients harm a detector more than its own, in one budget.

    A patch is another threat model, any grey level in a disc, and is not compared.

    Args:
        run: The run on the contested scenes.
    """
    known = run.records(setting=WHITE_BOX, planner=ENTERED)
    if not known:
        return False
    paired = paired_differences(known, run.records(setting=TRANSFERRED, planner=ENTERED))
    interval = None if paired is None else paired.safe_driving_rate.interval
    return interval is not None and interval[1] < 0


def _precision(run: RunFolder, setting: Setting, truth: Mapping[str, Any]) -> Precision | None:
    found = run.detections(setting.name)
    return moderate_precision(found, truth) if found else None


def moderate_precision(found: Mapping[str, Boxes3D], truth: Mapping[str, Boxes3D]) -> Precision:
    """The average precision of moderate cars.

    Args:
        found: Detections by frame, one or more; frames that are missing count on neither side.
        truth: Labels by frame.
    """
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
    return share_of([row.value > 0 for row in rows], [row.scenario for row in rows])


def share_of_episodes(records: Sequence[SafetyRecord], hits: Sequence[bool]) -> Share:
    """A share of all episodes; those of one scene are a cluster."""
    return share_of(hits, [record.scenario for record in records])
