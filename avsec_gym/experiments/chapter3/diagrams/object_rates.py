"""Which bogus objects detectors believe, and which attacks mismatches of objects reveal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.diagrams.evidence_cells import (
    ATTACKED_CAMERAS,
    CLEAN,
    clean_name,
)
from avsec_gym.experiments.chapter3.diagrams.object_cells import (
    WIDTH,
    believed_setting,
    seen_setting,
    truth_setting,
    views_setting,
)
from avsec_gym.experiments.chapter3.diagrams.settings import DiagramSettings
from avsec_gym.experiments.chapter3.diagrams.variant import Variant, is_of_lidar
from avsec_gym.experiments.chapter3.objects.baseline_rates import largest_count
from avsec_gym.experiments.chapter3.objects.believed_points import ATTACKED, score_name
from avsec_gym.experiments.chapter3.objects.mismatch_counts import IOUS
from avsec_gym.experiments.chapter3.objects.object_mismatches import mismatches
from avsec_gym.experiments.chapter3.objects.score_thresholds import ScoreThreshold, score_threshold
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED, SYSTEM
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.working_point import IN_IMAGE
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.results import Results
from avsec_gym.validation.recordings import drive_of

Boxes = Mapping[str, Boxes3D]
"""The boxes of each frame."""


@dataclass(frozen=True)
class BelievedVariant:
    """How often a bogus object is taken for an obstacle.

    Args:
        detector: The detector.
        variant: The attack.
        taken: Frames with a box at its place.
        newly: Frames with one that was not there without the attack.
    """

    detector: str
    variant: Variant = field(metadata=FLAT)
    taken: Share
    newly: Share


@dataclass(frozen=True)
class MismatchVariant:
    """How often objects that only one sensor sees reveal an attack: misplaced or missing ones.

    Args:
        iou: The IoU that partners exceed.
        variant: The attack; None: none.
        scan: Points that are left of the scan, 0 for all.
        most: Mismatches that raise no alarm yet.
        alarms: Frames with an alarm.
    """

    iou: float
    variant: Variant | None
    scan: int
    most: int
    alarms: Share


@dataclass(frozen=True)
class ObjectRates:
    """What detectors see of all attacks.

    Args:
        scores: The scores from which on a box counts, by detector and scan, as text.
        believed: How often bogus objects are believed, by detector and bogus object.
        mismatches: How often mismatches alarm, by IoU and attack, and without one.
    """

    scores: Mapping[str, ScoreThreshold]
    believed: Sequence[BelievedVariant]
    mismatches: Sequence[MismatchVariant]


def object_rates(
    results: Results, configuration: Configuration, rate: float, fewest: int
) -> ObjectRates | None:
    """The rates of a run; None with too few frames.

    Args:
        results: The results of a run.
        configuration: The configuration of the run.
        rate: The false alarm rate r that mismatches are to keep.
        fewest: Frames of each part that it takes.
    """
    settings = DiagramSettings.of(configuration)
    if not settings.believers:
        return None
    detectors, variants = settings.believers, settings.variants()
    # The score from which on a box counts, of each detector and scan, by clean frames to fit on.
    scores = {
        (name, scan): score_threshold(
            results, truth_setting(FITTED),
            seen_setting(name, FITTED, clean_name(scan), SYSTEM.reference),
        )
        for name in detectors for scan in settings.scans
    }  # fmt: skip
    # How often each detector of scans takes bogus points for an obstacle.
    believed = [
        row
        for name in detectors
        for variant in variants
        if is_of_lidar(variant)
        and (row := _believed(results, name, variant, scores[name, variant.scan].score, fewest))
    ]
    # The same score of the images' detector, whose objects the scan's are compared with.
    image = settings.image_detector
    camera = score_threshold(
        results,
        truth_setting(FITTED),
        seen_setting(image, FITTED, CLEAN, SYSTEM.reference),
        IN_IMAGE,
    )
    counts = _Counts(results, detectors[0], image, camera.score)
    # How often mismatches alarm, where clean frames to fit on keep the rate.
    found = []
    for scan in settings.scans:
        least = scores[detectors[0], scan].score
        clean = counts.of(FITTED, None, scan, least)
        if clean is None or len(clean.frames) < fewest:
            continue
        for variant in (None, *(each for each in variants if each.scan == scan)):
            judged = counts.of(JUDGED, variant, scan, least)
            if judged is None or len(judged.frames) < fewest:
                continue
            drives = [drive_of(id) for id in judged.frames]
            for column, iou in enumerate(IOUS):
                most = largest_count(clean.counts[:, column], rate)
                alarms = share_of(judged.counts[:, column] > most, drives)
                found.append(MismatchVariant(iou, variant, scan, most, alarms))
    if not believed and not found:
        return None
    named = {f"{name} of {scan}": score for (name, scan), score in scores.items()}
    return ObjectRates({**named, image: camera}, believed, found)


def _believed(
    results: Results, detector: str, variant: Variant, least: float, fewest: int
) -> BelievedVariant | None:
    setting = believed_setting(variant.name)
    taken, before = (
        {
            # No score, NaN, is stored where there is no box.
            row.scenario: row.value >= least
            for row in results.measurements(setting=setting, name=score_name(detector, state))
        }
        for state in (ATTACKED, CLEAN)
    )
    frames = sorted(taken.keys() & before.keys())
    if len(frames) < fewest:
        return None
    drives = [drive_of(id) for id in frames]
    hits, already = (np.array([by[id] for id in frames], bool) for by in (taken, before))
    return BelievedVariant(
        detector, variant, share_of(hits, drives), share_of(hits & ~already, drives)
    )


@dataclass(frozen=True, eq=False)
class _Mismatches:
    """Counts of N frames, a column for each of `IOUS`."""

    frames: Sequence[str]
    counts: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Counts:
    """Counts mismatches of the LiDAR's objects with those of either camera.

    Args:
        results: The results of a run.
        lidar: The LiDAR's detector.
        image: The images' detector.
        least: The score from which on a box of an image counts.
    """

    results: Results
    lidar: str
    image: str
    least: float

    def of(self, part: str, variant: Variant | None, scan: int, least: float) -> _Mismatches | None:
        """Counts of all frames that were shown to both; None: there are none.

        Args:
            part: `FITTED` or `JUDGED`.
            variant: The attack; None: none.
            scan: Points that are left of the scan.
            least: The score from which on a box of a scan counts.
        """
        widths = {
            row.scenario: row.value
            for row in self.results.measurements(setting=views_setting(part), name=WIDTH)
        }
        cameras = [int(SYSTEM.sensors[position]) for position in ATTACKED_CAMERAS]
        scan_name, in_scan, in_images = clean_name(scan), [], []
        for camera in cameras:
            images = dict(self._boxes(self.image, part, CLEAN, camera, self.least))
            if variant is not None and is_of_lidar(variant):
                scan_name = variant.name
            elif variant is not None:
                # In the frames in which this camera is attacked.
                images |= self._boxes(self.image, part, variant.name, camera, self.least)
            in_images.append(images)
        for camera in cameras:
            in_scan.append(self._boxes(self.lidar, part, scan_name, camera, least))
        frames = set.intersection(*(set(boxes) for boxes in (*in_scan, *in_images))) & set(widths)
        if variant is not None and not is_of_lidar(variant):
            # A frame that was not shown the light has none of its objects.
            frames &= {
                id for camera in cameras
                for id in self._boxes(self.image, part, variant.name, camera, self.least)
            }  # fmt: skip
        if not frames:
            return None
        ids = sorted(frames)
        counts = [
            [
                sum(
                    mismatches(images[id], scans[id], iou, 0.0, widths[id])
                    for images, scans in zip(in_images, in_scan, strict=True)
                )
                for iou in IOUS
            ]
            for id in ids
        ]
        return _Mismatches(ids, np.array(counts, float))

    def _boxes(self, detector: str, part: str, what: str, camera: int, least: float) -> Boxes:
        found = self.results.detections(seen_setting(detector, part, what, camera))
        return {id: boxes[boxes.score >= least] for id, boxes in found.items()}
