"""Every judged frame attacked in eleven ways, located and repaired: the work of `localisation`."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from avsec_gym.attacks.optical_attack import OpticalAttack, TamperedFrame
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.experiments.chapter3.localisation.measures import (
    CAR,
    attacks_of,
    found_again,
    measures_of,
)
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import (
    bogus_patch,
    taken_for_an_obstacle,
)
from avsec_gym.experiments.chapter3.objects.detector_weights import (
    WEIGHT_OPTIONS,
    lidar_detector,
    scan_alone,
    weight_inputs,
    weights_of,
)
from avsec_gym.experiments.chapter3.objects.object_mismatches import boxes_seen_by
from avsec_gym.experiments.chapter3.objects.pasted_cars import CarInView, CarsOfFrames, pasted_box
from avsec_gym.experiments.chapter3.recordings import (
    JUDGED,
    JUDGED_ASSETS,
    OPTIONS,
    drives_inputs,
    frame_cells,
    recordings_of,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.detections import above
from avsec_gym.perception.detectors import Detector, make_detector
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Measurement
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.repair.repair import REFILL_ERROR, Repair, repair

LOCALISATION_OPTIONS = {
    **JUDGED_ASSETS,
    "depth": OPTIONS["depth"],
    "refill_error": REFILL_ERROR,
    "detector": "",
    "scan_detector": "",
    "score_threshold": 0.3,
    "scan_score_threshold": 0.5,
    "dsgn": "",
    "stereo_rcnn": "",
    **{name: WEIGHT_OPTIONS[name] for name in ("pixor", "pointrcnn")},
}
"""Beside `JUDGED_ASSETS`: ``depth``: how disparities are found; ``refill_error``: see `repair`;
``detector``: a stereo detector whose objects are counted under attacks on a camera, none if empty;
``scan_detector``: one that looks at scans, for attacks on the LiDAR; ``score_threshold`` and
``scan_score_threshold``: of their boxes that count; by the networks' names their weights, instead
of those of the package."""

LOCALISATION_FORMAT = 3
"""Raised when something else is attacked or measured."""

_WORK = f"{__name__}:RepairedFrames"
_STREAM = 5
"""The stream of draws; the other experiments of chapter 3 have those below."""


@dataclass(frozen=True, eq=False)
class Attempt:
    """One attack on one frame, and what became of it.

    Args:
        clean: The frame without an attack.
        tampered: The attacked frame, as the car gets it.
        repaired: The repaired frame.
        bogus: The place of the bogus points of an attacked LiDAR.
    """

    clean: SensorFrame
    tampered: TamperedFrame
    repaired: Repair
    bogus: Boxes3D


def localisation_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every judged frame."""
    return frame_cells(_WORK, configuration, (JUDGED,), format=LOCALISATION_FORMAT)


def localisation_inputs(configuration: Configuration) -> dict[str, Path]:
    """Weights of the detectors, if any, and the manifest of procedural drives."""
    options = {**LOCALISATION_OPTIONS, **configuration.options}
    weights = weight_inputs([options["detector"], options["scan_detector"]], options)
    return weights | drives_inputs(configuration, (JUDGED,))


class RepairedFrames:
    """Attacks a frame, and repairs it with the attacked sensor named.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._options = {**LOCALISATION_OPTIONS, **configuration.options}
        self._depth = PairDepth(self._options["depth"])
        self._parts = {JUDGED: recordings_of(configuration, JUDGED)}
        self._reference = self._parts[JUDGED].system.reference
        self._attacks = attacks_of(self._reference)
        self._seed = configuration.seed
        self._cars = CarsOfFrames(self._parts[JUDGED].frames)

    @cached_property
    def _detector(self) -> Detector | None:
        # To make pictures again needs no weights.
        name = self._options["detector"]
        known = {"weights": weights_of(name, self._options)} if name in self._options else {}
        return make_detector({"name": name, **known}) if name else None

    @cached_property
    def _scan_detector(self) -> Detector | None:
        name = self._options["scan_detector"]
        return lidar_detector(name, self._options) if name else None

    def __call__(self, part: str, number: int, format: int) -> CellResult:
        """What `measures_of` gives for each attack; NaN where it is a share of nothing.

        With a detector of the attacked sensor also how many ``objects`` it finds in the clean
        images or scan, and how many of them in the attacked ones, ``found_before``, and in the
        repaired ones, ``found_after``; of a scan also ``found_cleaned``, in the one that only lacks
        what was found bogus, and whether it sees an obstacle where the bogus points
        are, ``bogus_before`` and ``bogus_after``, and whether there was one, ``bogus_clean``.

        Args:
            part: The part of the run: `JUDGED`.
            number: The number of the frame.
            format: `LOCALISATION_FORMAT`; cells of another one are done again.
        """
        recorded, seconds = self._parts[part].frames[number], dict[str, float]()
        clean = recorded.frame()
        in_images, in_scan = self._seen(clean, seconds), self._scanned(clean, seconds)
        rows = []
        for attack in self._attacks_on(number):
            attempt = self._attempt(clean, number, attack, seconds)
            found = measures_of(clean, attempt.tampered, attempt.repaired)
            if self._detector is not None and attempt.tampered.pixels:
                before, after = (
                    self._seen(state.frame, seconds)
                    for state in (attempt.tampered, attempt.repaired)
                )
                found |= _counts(in_images, before, after)
            if self._scan_detector is not None and attempt.tampered.points is not None:
                before, after = (
                    self._scanned(state.frame, seconds)
                    for state in (attempt.tampered, attempt.repaired)
                )
                found |= _counts(in_scan, before, after)
                cleaned = self._scanned(_not_refilled(attempt.repaired), seconds)
                found["found_cleaned"] = found_again(in_scan, cleaned)
                looks = {"clean": in_scan, "before": before, "after": after}
                for state, boxes in looks.items():
                    found[f"bogus_{state}"] = taken_for_an_obstacle(boxes, attempt.bogus)
            for name, value in found.items():
                known = math.nan if value is None else value
                rows.append(Measurement(attack, recorded.id, name, known))
        return CellResult(measurements=rows, seconds=seconds)

    def again(self, id: str, attack: str) -> Attempt:
        """One attack of a cell once more.

        Args:
            id: The id of the frame.
            attack: The attack as `attacks_of` calls it.

        Raises:
            DataError: The frame is no longer there.
        """
        recordings = self._parts[JUDGED]
        for number, recorded in enumerate(recordings.frames):
            if recorded.id == id:
                return self._attempt(recorded.frame(), number, attack, {})
        raise DataError(f"The frame {id} is no longer there.", path=recordings.root)

    def _attempt(
        self, clean: SensorFrame, number: int, attack: str, seconds: dict[str, float]
    ) -> Attempt:
        seed = (self._seed, number, _STREAM, [*self._attacks, CAR].index(attack))
        with _timed(seconds, "attack"):
            chosen = self._attacks_on(number)[attack]
            tampered = chosen.attack(clean, seed)
        with _timed(seconds, f"repair of {'a camera' if tampered.pixels else 'the LiDAR'}"):
            system = self._parts[JUDGED].system
            error = self._options["refill_error"]
            repaired = repair(tampered.frame, system, tampered.attacked, self._depth, error)
        bogus = Boxes3D.empty()
        if isinstance(chosen, CarInView):
            bogus = pasted_box(chosen.scan, tampered)
        elif tampered.points is not None:
            bogus = bogus_patch(tampered)
        return Attempt(clean, tampered, repaired, bogus)

    def _attacks_on(self, number: int) -> dict[str, OpticalAttack]:
        """`attacks_of`, and `CAR`, from the next other frame that has a labelled car."""
        count = len(self._parts[JUDGED].frames)
        scan = self._cars.first_of(range(number + 1, number + count))
        pasted = {} if scan is None else {CAR: CarInView(scan, self._reference)}
        return {**self._attacks, **pasted}

    def _scanned(self, frame: SensorFrame, seconds: dict[str, float]) -> Boxes3D:
        """As the reference sees it; nothing without a detector of scans."""
        if self._scan_detector is None:
            return Boxes3D.empty()
        with _timed(seconds, "scan detector"):
            found = self._scan_detector.detect(scan_alone(frame))
        found = above(found, self._options["scan_score_threshold"])
        size = frame.image(self._reference).shape[:2]
        return boxes_seen_by(found, frame.calibration.projection(self._reference), size)

    def _seen(self, frame: SensorFrame, seconds: dict[str, float]) -> Boxes3D:
        """Nothing without a detector."""
        if self._detector is None:
            return Boxes3D.empty()
        with _timed(seconds, "detector"):
            return above(self._detector.detect(frame), self._options["score_threshold"])


def _not_refilled(repaired: Repair) -> SensorFrame:
    assert repaired.refilled is not None, "a scan that was repaired"
    return repaired.frame.with_points(repaired.frame.points[~repaired.refilled])


def _counts(objects: Boxes3D, before: Boxes3D, after: Boxes3D) -> dict[str, float | None]:
    return {
        "objects": len(objects),
        "found_before": found_again(objects, before),
        "found_after": found_again(objects, after),
    }


@contextmanager
def _timed(seconds: dict[str, float], part: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    seconds[part] = seconds.get(part, 0.0) + time.perf_counter() - start
