"""Collisions and needless stops of a car, alone and connected, of each attack."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import get_args

from avsec_gym.experiments.chapter4.recovery.cells import KNOWN, Car, Case
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.runs.results import Results

Episodes = Mapping[tuple[str, str], SafetyRecord]
"""Records by scenario and intention."""


@dataclass(frozen=True)
class RecoveryRow:
    """What becomes of a car's episodes.

    Args:
        detector: The detector that is planned on.
        case: ``clean``, ``ghost`` or ``removal``.
        car: ``alone`` or ``connected``.
        collisions: Episodes that collide, of all.
        needless_stops: Episodes without a trajectory, of those for which one that is safe is found
            by a car that knows all.
        safe: Episodes that are safe, of all.
    """

    detector: str
    case: Case
    car: Car
    collisions: Share
    needless_stops: Share
    safe: Share


def recovery_rows(results: Results) -> list[RecoveryRow]:
    """The rows of a run: detector by detector, clean first, alone before connected.

    Shares are of clusters, the places.
    """
    settings = [setting for setting, _ in results.settings() if is_of_recovery(setting)]
    detectors = sorted({setting.rsplit(" ", 2)[0] for setting in settings})
    known = _episodes(results.records(setting=KNOWN))
    rows = []
    for detector in detectors:
        for case in get_args(Case):
            for car in get_args(Car):
                if f"{detector} {case} {car}" in settings:
                    found = _episodes(results.records(setting=f"{detector} {case} {car}"))
                    rows.append(_row(detector, case, car, found, known))
    return rows


def is_of_recovery(setting: str) -> bool:
    """Whether it names a detector, a case and a car."""
    words = setting.rsplit(" ", 2)
    return len(words) == 3 and words[1] in get_args(Case) and words[2] in get_args(Car)


def _row(detector: str, case: Case, car: Car, found: Episodes, known: Episodes) -> RecoveryRow:
    passable = {key: record for key, record in found.items() if known[key].safe}
    return RecoveryRow(
        detector,
        case,
        car,
        _share([record.collision for record in found.values()], found),
        _share([not record.planned for record in passable.values()], passable),
        _share([record.safe for record in found.values()], found),
    )


def _share(hits: Sequence[bool], of: Episodes) -> Share:
    return share_of(hits, [scenario for scenario, _ in of])


def _episodes(records: Sequence[SafetyRecord]) -> Episodes:
    return {(record.scenario, record.intention): record for record in records}
