"""Drives on in the frozen scenes: an experiment whose cells are these, and the rows of an entry."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.benchmark.loop_protocol import LoopSetting, loop_settings, models_of
from avsec_gym.benchmark.loop_scenes import CLOSED_LOOP, frozen_drives
from avsec_gym.benchmark.protocol import Entered, places_in
from avsec_gym.closed_loop.drive_record import Outcome
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.drives.summary import mean_over_scenes
from avsec_gym.experiments.json_rows import OPTIONAL
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Experiment, Measurement
from avsec_gym.runs.fingerprints import fingerprint
from avsec_gym.runs.results import Results

OPTIONS = {"kind": "planner", "part": {"name": "astar"}, "quick": False, "error_models": []}
"""What is entered, the part, whether only the scenes of a quick entry are driven in, and the error
models that were named."""
_WORK = "avsec_gym.benchmark.loop_drives:BenchmarkDrives"
_OF_ROW = ("at_fault", "collision", "progress_share", "navsim_score")
_OUTCOMES = (Outcome.OFF_ROAD, Outcome.GOAL)
_FIGURES = (*_OF_ROW, *map(str, _OUTCOMES))
"""What is kept of a drive: numbers of its row, and whether it ended in one of these ways."""


@dataclass(frozen=True)
class DrivesRow:
    """A setting in closed loop; intervals know which drives share a scene.

    Args:
        setting: Name of the setting, see `avsec_gym.benchmark.loop_protocol`.
        scenes: Number of scenes.
        at_fault: Drives that end in a collision by the car's own fault.
        collision: Drives that end in any collision.
        off_road: Drives that leave the road.
        goal: Drives that reach their goal.
        progress: Mean share of the way at the least cruising speed, as NAVSIM's score has it.
        navsim_score: Mean of NAVSIM's score.
        against: The setting that the differences are to, on the same drives.
        at_fault_difference: The difference of the share of drives at fault, this setting minus the
            other.
        navsim_difference: The difference of the mean score.
        attack: What the error model's card names as the attack.
        error_model: SHA-256 of the error model's file; empty: there is none.
        white_box: Whether the attack takes the gradients of the detector that it meets.
    """

    setting: str
    scenes: int
    at_fault: Share
    collision: Share
    off_road: Share
    goal: Share
    progress: Estimate
    navsim_score: Estimate
    against: str = ""
    at_fault_difference: Estimate | None = field(default=None, metadata=OPTIONAL)
    navsim_difference: Estimate | None = field(default=None, metadata=OPTIONAL)
    attack: Any = ""
    error_model: str = ""
    white_box: bool | None = field(default=None, metadata=OPTIONAL)


def drives_rows(run: Results, settings: Sequence[LoopSetting]) -> list[DrivesRow]:
    """The rows of the settings, in their order.

    Args:
        run: A run of `BENCHMARK_DRIVES`.
        settings: Its settings.
    """
    driven = {setting.name: _MeasuredDrives.of(run, setting.name) for setting in settings}
    rows = []
    for setting in settings:
        own = driven[setting.name]
        before = driven.get(setting.against)
        rows.append(
            DrivesRow(
                setting.name,
                len(set(own.scenes)),
                at_fault=own.share("at_fault"),
                collision=own.share("collision"),
                off_road=own.share("off_road"),
                goal=own.share("goal"),
                progress=own.mean("progress_share"),
                navsim_score=own.mean("navsim_score"),
                against=setting.against,
                at_fault_difference=own.difference(before, "at_fault"),
                navsim_difference=own.difference(before, "navsim_score"),
                attack=setting.attack,
                error_model="" if setting.model is None else fingerprint(setting.model),
                white_box=setting.white_box,
            )
        )
    return rows


@dataclass(frozen=True)
class _MeasuredDrives:
    """What was measured of the N drives of a setting.

    Args:
        values: The values by name and drive, drives in one order.
    """

    values: Mapping[str, Mapping[tuple[str, str], float]]

    @classmethod
    def of(cls, run: Results, setting: str) -> _MeasuredDrives:
        found: dict[str, dict[tuple[str, str], float]] = {name: {} for name in _FIGURES}
        for row in run.measurements(setting=setting):
            way, _, name = row.name.partition(" ")
            found[name][row.scenario, way] = row.value
        return cls({name: dict(sorted(own.items())) for name, own in found.items()})

    @property
    def scenes(self) -> list[str]:
        """The scene of each drive."""
        return [scene for scene, _ in self.values["goal"]]

    def share(self, name: str) -> Share:
        return share_of(self._array(name) > 0, self.scenes)

    def mean(self, name: str) -> Estimate:
        return self._estimate(self._array(name))

    def difference(self, before: _MeasuredDrives | None, name: str) -> Estimate | None:
        """The difference to the same drives of another setting; both lack failed cells."""
        if before is None:
            return None
        return self._estimate(self._array(name) - before._array(name))

    def _array(self, name: str) -> Floats:
        return np.array([*self.values[name].values()], float)

    def _estimate(self, values: Floats) -> Estimate:
        if not len(values):
            return NOTHING
        mean = mean_over_scenes(values, self.scenes)
        return Estimate(mean.value, mean.interval)


def _settings(configuration: Configuration) -> list[LoopSetting]:
    options = configuration.options
    return loop_settings(Entered(options["kind"]), options["part"], options["error_models"])


def _cells(configuration: Configuration) -> list[Cell]:
    """A cell for every scene."""
    ids = frozen_drives().ids(quick=bool(configuration.options["quick"]))
    return [Cell.of(_WORK, id, scenario=id) for id in ids]


def _inputs(configuration: Configuration) -> dict[str, Path]:
    """What a run does not go on without, or with other content."""
    settings = _settings(configuration)
    inputs = {f"error model {name}": path for name, path in models_of(settings).items()}
    for setting in settings:
        inputs |= places_in(setting.planner)
    return inputs


class BenchmarkDrives:
    """Drives in a scene under every setting; see `avsec_gym.runs.experiment.Work`.

    Args:
        configuration: The configuration of the run.

    Raises:
        ConfigurationError: There is no such part.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._frozen = frozen_drives()
        scenes = self._frozen.scenes
        self._cars = {
            car.name: DriveSetting(
                car.name, {"perception": car.perception, "planner": car.planner}
            ).environment(scenes)
            for car in _settings(configuration)
        }

    def __call__(self, scenario: str) -> CellResult:
        """The results of one cell.

        Args:
            scenario: The scene's id.
        """
        measured = [
            Measurement(setting, scenario, f"{way} {name}", value)
            for way in self._frozen.ways[scenario]
            for setting, car in self._cars.items()
            for name, value in _figures(
                car,
                DriveTask(setting, scenario, str(way), self._frozen.number(scenario, way)),
            )
        ]
        return CellResult(measurements=measured)


def _figures(car: Any, task: DriveTask) -> Iterator[tuple[str, float]]:
    """What is kept of a drive."""
    row = drive(car, task).row
    for name in _OF_ROW:
        yield name, float(row[name])
    for outcome in _OUTCOMES:
        yield str(outcome), float(row["outcome"] == outcome)


BENCHMARK_DRIVES = Experiment(
    "benchmark_drives",
    "How does a car drive on with this part, all else being as frozen?",
    "",
    _cells,
    inputs=_inputs,
    options=OPTIONS,
    usual=Configuration(CLOSED_LOOP),
)
