"""Are attacks detected before they harm?  Detection rate and precision over an attack's size.

Thesis, section 3.5: thresholds for r = 1 %, AP at IoU 0.7.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from avsec_gym.experiments.chapter3.identification.identification_rates import CRITERIA
from avsec_gym.experiments.chapter3.identification.summary import FEWEST
from avsec_gym.experiments.chapter3.objects.attack_sizes import (
    CAMERA,
    COVERED,
    SIZE_OPTIONS,
    SIZES,
    THREE_SENSORS,
    TRUTH,
    size_setting,
)
from avsec_gym.experiments.chapter3.objects.car_precision import (
    PrecisionAtLevel,
    Precisions,
    car_precision,
    precision_rows,
)
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.rig import KITTI_SIZE
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.evidence.disparity_error import MEASURES
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.recordings import drive_of
from avsec_gym.validation.thresholds import ThresholdTable

RATE = 0.01
"""r."""
IOU = 0.7
_METRIC = {LIDAR: "3d", CAMERA: "2d"}
_DETECTOR = {LIDAR: "sensitivity_lidar", CAMERA: "sensitivity_image"}


@dataclass(frozen=True)
class CoveredArea:
    """How much of the image a facula covers, in [0, 1].

    Args:
        covered: The share of its disc, as the thesis counts it.
        changed: The mean share that it changes visibly.
    """

    covered: float
    changed: float


@dataclass(frozen=True)
class SizeRow:
    """What is detected, and what a detector still finds, of one size of an attack.

    Args:
        size: Metres of width, or pixels of radius; 0: clean.
        area: How much of the image a facula covers; None of a bogus return.
        detected: Frames with an alarm, by criterion (`CRITERIA`); clean: false alarms.
        precision: Average precision by level, at IoU 0.7; None without detector or labels.
    """

    size: float
    area: CoveredArea | None = field(metadata=FLAT)
    detected: Mapping[str, Share]
    precision: Mapping[str, PrecisionAtLevel] | None


@dataclass(frozen=True)
class SensitivityCurve:
    """One attack in all its sizes.

    Args:
        detector: The detector whose precision is measured; empty: none.
        metric: The metric of its precision.
        iou: The IoU that a match exceeds.
        sizes: The sizes, clean frames first.
    """

    detector: str
    metric: str
    iou: float
    sizes: Sequence[SizeRow]


@dataclass(frozen=True)
class SensitivitySummary:
    """Both curves of a run.

    Args:
        frames: The number of frames of each part.
        rate: The designated false alarm rate r.
        lidar: The curve of bogus returns.
        camera: The curve of faculae.
    """

    frames: Mapping[str, int]
    rate: float
    lidar: SensitivityCurve
    camera: SensitivityCurve

    @property
    def curves(self) -> dict[str, SensitivityCurve]:
        """The curves of `LIDAR` and of `CAMERA`."""
        return {LIDAR: self.lidar, CAMERA: self.camera}


def sensitivity_summary(
    results: Results, configuration: Configuration
) -> SensitivitySummary | None:
    """Both curves of a run; None where either part has fewer than `FEWEST` frames."""
    options = {**SIZE_OPTIONS, **configuration.options}
    fitted, _ = _shares(results, size_setting(FITTED), 0.0)
    clean = _shares(results, size_setting(JUDGED), 0.0)
    counts = {FITTED: len(fitted), JUDGED: len(clean[0])}
    if min(counts.values()) < FEWEST:
        return None
    # These thresholds are not kept: their scales do not matter.
    on = FittedOn(THREE_SENSORS, PairDepth(options["depth"]).settings, (), {})
    table = ThresholdTable(on, fitted[:, None])
    [triple] = THREE_SENSORS.triples
    thresholds = {name: table.thresholds(RATE, name)[triple].shares for name in CRITERIA}
    curves = {}
    for what, sizes in SIZES.items():
        setting = size_setting(what)
        precisions = _precisions(results, what)
        rows = []
        for size in (0.0, *sizes):
            shares, drives = _shares(results, setting, size) if size else clean
            if not len(shares):
                continue
            rows.append(
                SizeRow(
                    size,
                    _area(results, setting, size) if what == CAMERA else None,
                    detected={
                        name: share_of((shares > limits).any(axis=1), drives)
                        for name, limits in thresholds.items()
                    },
                    precision=precision_rows(precisions[0.0], precisions[size])
                    if {0.0, size} <= precisions.keys()
                    else None,
                )
            )
        curves[what] = SensitivityCurve(options[_DETECTOR[what]], _METRIC[what], IOU, rows)
    return SensitivitySummary(counts, RATE, curves[LIDAR], curves[CAMERA])


def disc_share(radius: float) -> float:
    """The share of KITTI's image that a whole disc takes, as the thesis counts it.

    Example:
        >>> round(100 * disc_share(225), 2)
        34.15
    """
    return float(np.pi * radius**2 / (KITTI_SIZE[0] * KITTI_SIZE[1]))


def _area(results: Results, setting: str, size: float) -> CoveredArea:
    if not size:
        return CoveredArea(0.0, 0.0)
    rows = results.measurements(name=COVERED, setting=setting, strength=size)
    return CoveredArea(disc_share(size), float(np.mean([row.value for row in rows])))


def _shares(results: Results, setting: str, size: float) -> tuple[Floats, list[str]]:
    """All `MEASURES` of each frame, shape (N, 4), and its drive."""
    rows = [results.measurements(name=name, setting=setting, strength=size) for name in MEASURES]
    values = np.array([[row.value for row in column] for column in rows], float)
    drives = [drive_of(row.scenario) for row in rows[0]]
    return values.T.reshape(-1, len(MEASURES)), drives


def _precisions(results: Results, what: str) -> dict[float, Precisions]:
    """By size; of the frames that were looked at in all of them."""
    truth = results.detections(TRUTH)
    found = {size: results.detections(size_setting(what), size) for size in (0.0, *SIZES[what])}
    found = {size: boxes for size, boxes in found.items() if boxes}
    frames = sorted(truth.keys() & set.intersection(*map(set, found.values()), set(truth)))
    if len(frames) < FEWEST:
        return {}
    return {
        size: car_precision(truth, boxes, frames, _METRIC[what], IOU)
        for size, boxes in found.items()
    }
