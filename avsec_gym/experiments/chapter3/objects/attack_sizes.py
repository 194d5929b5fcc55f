"""The same attack, smaller and larger: the evidence of the sensors, and what detectors see.

The work of the sensitivity curves (thesis, section 3.5).  A frame's attack stands at one place in
all sizes: only the size differs.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import OpticalAttack
from avsec_gym.experiments.chapter3.objects.detector_weights import (
    WEIGHT_OPTIONS,
    image_detector,
    lidar_detector,
    weight_inputs,
)
from avsec_gym.experiments.chapter3.objects.frame_truth import truth_of
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    OPTIONS,
    SYSTEM,
    drives_inputs,
    frame_cells,
    recordings_of,
)
from avsec_gym.experiments.chapter3.settings import SCENARIOS
from avsec_gym.frame import SensorFrame
from avsec_gym.runs.experiment import (
    Cell,
    CellResult,
    Configuration,
    DetectionRow,
    Measurement,
)
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import MEASURES, DisparityError, DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.evidence import EVIDENCE_FORMAT
from avsec_gym.validation.evidence.pair_depth import PairDepth

WIDTHS = (0.5, 1.0, 1.5, 2.0, 2.5)
"""Widths of bogus returns, metres."""
RADII = (37.5, 75.0, 112.5, 150.0, 187.5, 225.0)
"""Radii of faculae, pixels of an image 1242 wide."""
CAMERA = "camera"
SIZES = {LIDAR: WIDTHS, CAMERA: RADII}
"""Sizes by what is attacked."""
SIZE_OPTIONS = {
    **OPTIONS,
    "sensitivity_lidar": "pointrcnn",
    "sensitivity_image": "yolo",
    **{name: WEIGHT_OPTIONS[name] for name in ("pointrcnn", "yolo")},
}
"""Beside those of the recordings: ``sensitivity_lidar`` and ``sensitivity_image``: whose precision
is measured, not measured if empty; by the networks' names their weights."""
COVERED = "covered"
"""Share of the image in which a facula changes something visibly, within its radius."""
TRUTH = "sizes truth"
"""Setting of what is really there."""
THREE_SENSORS = SensorSystem(
    tuple(SYSTEM.sensors[position] for position in SCENARIOS["LiDAR and two cameras"])
)
"""The sensors that detect the attacks: a LiDAR, a camera, and the reference left of it."""

_WORK = f"{__name__}:AttackSizes"
_STREAM = {LIDAR: 3, CAMERA: 4}


def size_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every frame, first the clean ones that thresholds are fitted on."""
    return frame_cells(_WORK, configuration, (FITTED, JUDGED), format=EVIDENCE_FORMAT)


def size_inputs(configuration: Configuration) -> dict[str, Path]:
    """Weights, and the manifests of procedural drives."""
    options = {**SIZE_OPTIONS, **configuration.options}
    # First what may lack, then what may take hours to be made.
    found = weight_inputs((options["sensitivity_lidar"], options["sensitivity_image"]), options)
    return found | drives_inputs(configuration, (FITTED, JUDGED))


def size_setting(what: str) -> str:
    """What results are filed under: of an attack its size is the strength, of clean frames 0.

    Args:
        what: `LIDAR` or `CAMERA`, which are attacked; or the part that clean frames belong to.
    """
    return f"sizes {what}"


class AttackSizes:
    """Attacks a frame in all sizes.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        options = {**SIZE_OPTIONS, **configuration.options}
        lidar, image = options["sensitivity_lidar"], options["sensitivity_image"]
        self._lidar = lidar_detector(lidar, options) if lidar else None
        self._image = image_detector(image, options) if image else None
        self._depth = PairDepth(options["depth"])
        self._parts = {part: recordings_of(configuration, part) for part in (FITTED, JUDGED)}
        self._seed = configuration.seed

    def __call__(self, part: str, number: int, format: int) -> CellResult:
        """Disparity errors and detections, clean and in every size; of a fitted frame errors only.

        Args:
            part: `FITTED` or `JUDGED`.
            number: The number of the frame.
            format: `EVIDENCE_FORMAT` of what is measured; cells of another one are done again.
        """
        recorded = self._parts[part].frames[number]
        frame = recorded.frame()
        seconds: dict[str, float] = {}
        start = time.perf_counter()
        maps = DisparityMaps(frame, THREE_SENSORS, self._depth)
        rows = _measurements(size_setting(part), recorded.id, _error(maps))
        seconds["evidence"] = time.perf_counter() - start
        if part == FITTED:
            return CellResult(measurements=rows, seconds=seconds)
        truth = truth_of(frame, THREE_SENSORS.reference)
        detections = [DetectionRow(TRUTH, recorded.id, truth)] if truth is not None else []
        for what, sizes in SIZES.items():
            setting = size_setting(what)
            start = time.perf_counter()
            detections += self._seen(what, recorded.id, frame, 0.0)
            seconds[f"{what} detector"] = time.perf_counter() - start
            seed = (self._seed, number, _STREAM[what])
            largest = attack_of_size(what, sizes[-1]).attack(frame, seed)
            for size in sizes:
                start = time.perf_counter()
                bearing = largest.settings.get("bearing")
                tampered = attack_of_size(what, size, bearing).attack(frame, seed)
                seconds["attack"] = seconds.get("attack", 0.0) + time.perf_counter() - start
                start = time.perf_counter()
                # A scan leaves the cameras' own map as it is.
                known = {(1, 2): maps.view((1, 2))} if what == LIDAR else None
                attacked = DisparityMaps(tampered.frame, THREE_SENSORS, self._depth, known)
                rows += _measurements(setting, recorded.id, _error(attacked), size)
                seconds["evidence"] += time.perf_counter() - start
                for pixels in tampered.pixels.values():
                    share = float(pixels.mean())
                    rows.append(Measurement(setting, recorded.id, COVERED, share, size))
                start = time.perf_counter()
                detections += self._seen(what, recorded.id, tampered.frame, size)
                seconds[f"{what} detector"] += time.perf_counter() - start
        return CellResult(detections=detections, measurements=rows, seconds=seconds)

    def _seen(self, what: str, id: str, frame: SensorFrame, size: float) -> list[DetectionRow]:
        if what == LIDAR and self._lidar is not None:
            found = self._lidar.detect(frame)
        elif what == CAMERA and self._image is not None:
            found = self._image.detect(frame, THREE_SENSORS.reference)
        else:
            return []
        return [DetectionRow(size_setting(what), id, found, size)]


def attack_of_size(what: str, size: float, bearing: float | None = None) -> OpticalAttack:
    """The thesis' attack in another size.

    Args:
        what: `LIDAR`, or `CAMERA`, which is the reference.
        size: Metres of width, or pixels of radius.
        bearing: The bearing of a bogus return, radians; None: drawn where this width is seen whole.
            A facula's centre does not depend on its radius.
    """
    reference = THREE_SENSORS.reference
    if what == LIDAR:
        return LidarSpoofing(width=size, bearing=bearing, reference=reference)
    return Facula(reference, size)


def _error(maps: DisparityMaps) -> DisparityError:
    """E_{0,1,2}."""
    return DisparityErrors(maps)[0, 1, 2]


def _measurements(
    setting: str, id: str, error: DisparityError, size: float = 0.0
) -> list[Measurement]:
    values: Sequence[float] = error.shares.tolist()
    return [
        Measurement(setting, id, name, value, size)
        for name, value in zip(MEASURES, values, strict=True)
    ]
