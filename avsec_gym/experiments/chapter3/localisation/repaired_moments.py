"""Every judged moment attacked in ten ways, located and repaired: the work of `localisation`."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.experiments.chapter3.localisation.measures import (
    attacks_of,
    found_again,
    measures_of,
)
from avsec_gym.experiments.chapter3.objects.detector_weights import weight_inputs, weights_of
from avsec_gym.experiments.chapter3.recordings import (
    JUDGED,
    OPTIONS,
    drives_inputs,
    moment_cells,
    recordings_of,
)
from avsec_gym.experiments.experiment import Cell, CellResult, Configuration, Measurement
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.detections import above
from avsec_gym.perception.detectors import Detector, make_detector
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.repair.repair import Repair, repair

LOCALISATION_OPTIONS = {
    "depth": OPTIONS["depth"],
    "detector": "",
    "score_threshold": 0.3,
    "dsgn": "",
    "stereo_rcnn": "",
}
"""``depth``: how disparities are found; ``detector``: a stereo detector whose objects are counted
under attacks on a camera, nobody's if empty; ``score_threshold``: of boxes that count; by the
networks' names their weights, instead of those of the package."""

_WORK = f"{__name__}:RepairedMoments"
_STREAM = 5
"""Of draws; the other experiments of chapter 3 have those below."""


@dataclass(frozen=True, eq=False)
class Attempt:
    """One attack on one moment, and what became of it.

    Args:
        clean: The moment as it is.
        tampered: As the car gets it.
        mended: Repaired.
    """

    clean: SensorFrame
    tampered: TamperedFrame
    mended: Repair


def localisation_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every judged moment."""
    return moment_cells(_WORK, configuration, (JUDGED,))


def localisation_inputs(configuration: Configuration) -> dict[str, Path]:
    """Weights of the detector, if any, and the manifest of procedural drives."""
    options = {**LOCALISATION_OPTIONS, **configuration.options}
    weights = weight_inputs([options["detector"]], options)
    return weights | drives_inputs(configuration, (JUDGED,))


class RepairedMoments:
    """Attacks a moment, and repairs it with the attacked sensor named.

    Args:
        configuration: Of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._options = {**LOCALISATION_OPTIONS, **configuration.options}
        self._depth = PairDepth(self._options["depth"])
        self._parts = {JUDGED: recordings_of(configuration, JUDGED)}
        self._attacks = attacks_of(self._parts[JUDGED].system.reference)
        self._seed = configuration.seed

    @cached_property
    def _detector(self) -> Detector | None:
        # Who only makes pictures again needs no weights.
        name = self._options["detector"]
        known = {"weights": weights_of(name, self._options)} if name in self._options else {}
        return make_detector({"name": name, **known}) if name else None

    def __call__(self, part: str, number: int) -> CellResult:
        """What `measures_of` tells of each attack; NaN where it is a share of nothing.

        With a detector, of attacks on a camera also how many ``objects`` it finds in the clean
        images, and how many of them in the attacked ones, ``found_before``, and in the repaired
        ones, ``found_after``.

        Args:
            part: `JUDGED`.
            number: Of the moment.
        """
        moment, seconds = self._parts[part].moments[number], dict[str, float]()
        clean = moment.frame()
        objects = self._seen(clean, seconds)
        rows = []
        for attack in self._attacks:
            attempt = self._attempt(clean, number, attack, seconds)
            found = measures_of(clean, attempt.tampered, attempt.mended)
            if self._detector is not None and attempt.tampered.pixels:
                before, after = (
                    self._seen(one.frame, seconds) for one in (attempt.tampered, attempt.mended)
                )
                found["objects"] = len(objects)
                found["found_before"] = found_again(objects, before)
                found["found_after"] = found_again(objects, after)
            for name, value in found.items():
                known = math.nan if value is None else value
                rows.append(Measurement(attack, moment.id, name, known))
        return CellResult(measurements=rows, seconds=seconds)

    def again(self, moment: str, attack: str) -> Attempt:
        """One attack of a cell once more.

        Args:
            moment: Its id.
            attack: As `attacks_of` calls it.

        Raises:
            DataError: The moment is no longer there.
        """
        recordings = self._parts[JUDGED]
        for number, one in enumerate(recordings.moments):
            if one.id == moment:
                return self._attempt(one.frame(), number, attack, {})
        raise DataError(f"The moment {moment} is no longer there.", path=recordings.root)

    def _attempt(
        self, clean: SensorFrame, number: int, attack: str, seconds: dict[str, float]
    ) -> Attempt:
        seed = (self._seed, number, _STREAM, list(self._attacks).index(attack))
        with _timed(seconds, "attack"):
            tampered = self._attacks[attack].attack(clean, seed)
        with _timed(seconds, f"repair of {'a camera' if tampered.pixels else 'the LiDAR'}"):
            system = self._parts[JUDGED].system
            mended = repair(tampered.frame, system, tampered.attacked, self._depth)
        return Attempt(clean, tampered, mended)

    def _seen(self, frame: SensorFrame, seconds: dict[str, float]) -> Boxes3D:
        """Nothing without a detector."""
        if self._detector is None:
            return Boxes3D.empty()
        with _timed(seconds, "detector"):
            return above(self._detector.detect(frame), self._options["score_threshold"])


@contextmanager
def _timed(seconds: dict[str, float], part: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    seconds[part] = seconds.get(part, 0.0) + time.perf_counter() - start
