"""The work of the experiment on drives: the scores of each instant, attack-free and attacked."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter4.compared_instant import ComparedInstant, compared_instant
from avsec_gym.experiments.chapter4.drives.settings import (
    DRIVE_METHODS,
    DRIVE_STATES,
    GHOST,
    OPTIONS,
    WINDOW,
    drive_setting,
)
from avsec_gym.experiments.chapter4.instant_cells import constants_under
from avsec_gym.experiments.chapter4.procedural_instants import ASSETS, scanned_instant
from avsec_gym.experiments.chapter4.settings import CLEAN, FITTED, JUDGED, USUAL, Part, State
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Measurement
from avsec_gym.validation.connected.attacks.moving_ghost import MovingGhost
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.learned.learned_fit import SHIPPED_MODEL, read_learned_fit
from avsec_gym.validation.connected.proposals.clusters import ClusterProposer
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.export import clock_offsets, measured_pose, pose_errors

USUAL_DRIVES = 200
_WORK = f"{__name__}:ConnectedDrives"
_FORMAT = 1
"""Raised when what is measured changes, so that cells are done again."""
_FIRST_SET: dict[Part, int] = {FITTED: 7000, JUDGED: 8000}
"""Numbers of the sets of drives, none of which anything else was made from."""
_MOST_WINDOWS = 100


def drive_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every drive; drives to fit on and to judge take turns.

    Raises:
        ConfigurationError: Data other than procedural ones, or no such number of windows.
    """
    if configuration.scenarios != PROCEDURAL:
        raise ConfigurationError(
            f"chapter4_drives judges drives of the procedural world: --scenarios is {PROCEDURAL!r},"
            f" got {configuration.scenarios!r}; `avsec connected --sequence {WINDOW} --data` judges"
            " other data"
        )
    if not 0 <= configuration.seed < 1000:
        raise ConfigurationError(f"a seed of drives is from 0 to 999, got {configuration.seed}")
    windows = {**OPTIONS, **configuration.options}["windows"]
    if type(windows) is not int or not 1 <= windows <= _MOST_WINDOWS:
        raise ConfigurationError(f"windows are 1 to {_MOST_WINDOWS}, got {windows!r}")
    return [
        Cell.of(
            _WORK,
            f"{part} {number}",
            part=part,
            number=number,
            windows=windows,
            format=_FORMAT,
        )
        for number in range(configuration.limit or USUAL_DRIVES)
        for part in DRIVE_STATES
    ]


def drive_inputs(configuration: Configuration) -> dict[str, Path]:
    """The fit that constants come from, and the model of the learned comparison."""
    given = {**OPTIONS, **configuration.options}
    return {
        "constants": Path(given["constants"] or SHIPPED_FIT),
        "model": Path(given["model"] or SHIPPED_MODEL),
    }


class ConnectedDrives:
    """Measures the instants of drives.

    Args:
        configuration: The configuration of the run.

    Raises:
        DataError: The file of constants, or of the model, is missing or damaged.
    """

    def __init__(self, configuration: Configuration) -> None:
        files = drive_inputs(configuration)
        self._fit = read_connected_fit(files["constants"])
        self._constants = constants_under(self._fit, USUAL)
        self._learned = read_learned_fit(files["model"]).rule()
        self._seed, self._proposer = configuration.seed, ClusterProposer()

    def __call__(self, part: Part, number: int, windows: int, format: int) -> CellResult:
        """The scores of all instants of a drive.

        Args:
            part: `FITTED` or `JUDGED`.
            number: Number of the drive.
            windows: Number of its windows.
            format: Format of what is measured; cells of another one are done again.
        """
        rows: list[Measurement] = []
        seconds = {f"judge {state}": 0.0 for state in DRIVE_STATES[part]}
        # Each window has a ghost of its own, which begins with it.
        begun = None
        for frame, instant in enumerate(self._instants(part, number, windows * WINDOW)):
            self._fit.check(instant.scans)
            rows += self._rows(part, CLEAN, number, frame, self._compared(instant, seconds, CLEAN))
            if GHOST not in DRIVE_STATES[part]:
                continue
            if frame % WINDOW == 0:
                begun = MovingGhost().begin(instant, (self._seed, number, frame))
            attacked = begun and begun.attack(instant, 0.1 * (frame % WINDOW))
            if attacked:
                compared = self._compared(attacked.instant, seconds, GHOST)
                rows += self._rows(part, GHOST, number, frame, compared)
                about = attacked.regions(compared.regions) & compared.decidable
                rows.append(_row(part, GHOST, number, f"decidable {frame}", float(about.any())))
        return CellResult(measurements=rows, seconds=seconds)

    def _compared(
        self, instant: RecordedInstant, seconds: dict[str, float], state: State
    ) -> ComparedInstant:
        begin = time.perf_counter()
        compared = compared_instant(instant.scans, self._constants, self._proposer, self._learned)
        seconds[f"judge {state}"] += time.perf_counter() - begin
        return compared

    def _instants(self, part: Part, number: int, frames: int) -> Iterator[RecordedInstant]:
        """The instants as the vehicles measure them, 0.1 s apart."""
        name, vehicles = _FIRST_SET[part] + self._seed, USUAL.vehicles
        scenes = drive_scenes(name, number, frames, vehicles, assets=ASSETS[part])
        offsets = clock_offsets(name, number, vehicles, USUAL.clocks_apart).tolist()
        errors = [pose_errors(name, number, vehicle, frames) for vehicle in range(vehicles)]
        for frame in range(frames):
            id = f"{number:06d}/{frame:06d}"
            whole = scanned_instant(scenes[frame], offsets, number, frame, id)
            scans = tuple(
                replace(scan, pose=measured_pose(scan.pose, error[frame], USUAL.noise, USUAL.noise))
                for scan, error in zip(whole.scans, errors, strict=True)
            )
            yield replace(whole, scans=scans)

    def _rows(
        self, part: Part, state: State, number: int, frame: int, compared: ComparedInstant
    ) -> list[Measurement]:
        """The highest score of the decidable regions, by method; NaN without any."""
        rows = []
        for method in DRIVE_METHODS:
            scores = compared.results[method].score[compared.decidable]
            highest = float(scores.max(initial=-np.inf))
            value = highest if np.isfinite(highest) else np.nan
            rows.append(_row(part, state, number, f"{method} {frame}", value))
        return rows


def _row(part: Part, state: State, number: int, name: str, value: float) -> Measurement:
    return Measurement(drive_setting(part, state), f"{number:06d}", name, value)
