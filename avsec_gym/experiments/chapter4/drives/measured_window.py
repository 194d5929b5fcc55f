"""What is kept of a window: the scores of its tracks, as rows of a run and read back from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter4.drives.settings import TOLERANCE, drive_setting
from avsec_gym.experiments.chapter4.settings import Part, State
from avsec_gym.geometry import Floats
from avsec_gym.runs.experiment import Measurement
from avsec_gym.runs.results import Results
from avsec_gym.validation.connected.attacks.attacked_instant import AttackedInstant
from avsec_gym.validation.connected.rays.rates import RayRates, decidable
from avsec_gym.validation.connected.region_tracks import NO_REGION, region_tracks
from avsec_gym.validation.connected.regions import Regions
from avsec_gym.validation.connected.result import ConnectedResult

_LASTED, _COVERED, _DECIDABLE = "lasted", "covered", "decidable"


@dataclass(frozen=True, eq=False)
class MeasuredWindow:
    """A window without an attack, or under one, of T instants and K tracks of regions.

    Args:
        drive: Name of the drive.
        lasted: Number of its instants; an attack ends where the victim drives into the ghost, or
            has no more points on what is removed.
        covered: Whether some region is about the attack, at some instant.
        decidable: Number of instants at which, in one of these regions, the rays of another
            vehicle, at the victim's claim of a ghost, or the victim's at another's claim of what
            is removed, are enough to decide, whatever they show.
        scores: The score of each track at each instant, NaN without one, shape (K, T).
        about: Whether the track's region is about the attack then, shape (K, T).
    """

    drive: str
    lasted: int
    covered: bool
    decidable: int
    scores: Floats
    about: NDArray[np.bool_]


def measured_window(
    drive: str,
    results: Sequence[ConnectedResult],
    attacked: Sequence[AttackedInstant],
    rates: RayRates,
    quiet: bool,
) -> MeasuredWindow:
    """The window of successive instants, one or more.

    Args:
        drive: Name of the drive.
        results: What was decided at each instant.
        attacked: The attack at each instant; empty without one.
        rates: The chances of rays.
        quiet: Whether tracks are kept that never speak for an attack: no sum over them rises.
    """
    tracks = region_tracks([result.regions for result in results])
    scores, about = np.full(tracks.shape, np.nan), np.zeros(tracks.shape, bool)
    covered, decided = False, 0
    for time, result in enumerate(results):
        there = tracks[:, time] != NO_REGION
        region = tracks[there, time]
        score = result.score[region]
        scores[there, time] = np.where(np.isfinite(score), score, np.nan)
        if attacked:
            within = within_box(result.regions, attacked[time].box)
            about[there, time] = within[region]
            covered |= bool(within.any())
            touched = within & _touches_victim(result, attacked[time], rates)
            decided += bool(touched.any())
    kept = np.full(len(tracks), quiet) | (np.nan_to_num(scores) > 0).any(axis=1)
    return MeasuredWindow(drive, len(results), covered, decided, scores[kept], about[kept])


def within_box(regions: Regions, box: Regions) -> NDArray[np.bool_]:
    """Whether the centre of each region lies in a box that is grown by `TOLERANCE`, shape (R,).

    Args:
        regions: R regions, world frame.
        box: The box, one region.
    """
    local = np.abs(box.local(0, regions.centre)[:, :2])
    return np.asarray((local <= 0.5 * box.size[0, :2] + TOLERANCE).all(axis=1))


def _touches_victim(
    result: ConnectedResult, attacked: AttackedInstant, rates: RayRates
) -> NDArray[np.bool_]:
    """Whether a testimony of the victim's claim, or by the victim, decides, shape (R,)."""
    assert result.counts is not None
    pairs = decidable(result.counts, rates)
    victim = attacked.victim
    of_victim = pairs[:, victim, :] if attacked.kind == "ghost" else pairs[:, :, victim]
    return np.asarray(of_victim.any(axis=1))


def rows_of(window: MeasuredWindow, part: Part, state: State, number: int) -> list[Measurement]:
    """The rows of a window.

    Args:
        window: The window.
        part: `FITTED` or `JUDGED`.
        state: The state.
        number: Number of the window in its drive.
    """
    columns: dict[str, float] = {
        _LASTED: window.lasted,
        _COVERED: float(window.covered),
        _DECIDABLE: window.decidable,
    }
    for track, time in np.argwhere(np.isfinite(window.scores)).tolist():
        columns[f"score {track} {time}"] = float(window.scores[track, time])
        if window.about[track, time]:
            columns[f"about {track} {time}"] = 1.0
    scenario = f"{window.drive}/{number:03d}"
    setting = drive_setting(part, state)
    return [Measurement(setting, scenario, name, value) for name, value in columns.items()]


def measured_windows(run: Results, part: Part, state: State) -> list[MeasuredWindow]:
    """The windows that a run holds, in order.

    Args:
        run: The results of a run.
        part: `FITTED` or `JUDGED`.
        state: The state.
    """
    found: dict[str, dict[str, float]] = {}
    for row in run.measurements(setting=drive_setting(part, state)):
        found.setdefault(row.scenario, {})[row.name] = row.value
    return [_window(name, columns) for name, columns in sorted(found.items())]


def _window(name: str, columns: dict[str, float]) -> MeasuredWindow:
    lasted, entries = int(columns[_LASTED]), []
    for column, value in columns.items():
        kind, *place = column.split()
        if place:
            entries.append((kind, int(place[0]), int(place[1]), value))
    tracks = 1 + max((track for _, track, _, _ in entries), default=-1)
    scores, about = np.full((tracks, lasted), np.nan), np.zeros((tracks, lasted), bool)
    for kind, track, time, value in entries:
        if kind == "score":
            scores[track, time] = value
        else:
            about[track, time] = True
    drive = name.partition("/")[0]
    covered, decided = columns[_COVERED] > 0, int(columns[_DECIDABLE])
    return MeasuredWindow(drive, lasted, covered, decided, scores, about)
