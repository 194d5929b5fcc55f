"""The evidence of all sensors under every attack of the diagrams, frame by frame and matcher."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from avsec_gym.experiments.chapter3.attacks import tampered_frames
from avsec_gym.experiments.chapter3.diagrams.scan_rings import kept_rings, on_rings
from avsec_gym.experiments.chapter3.diagrams.settings import DiagramSettings
from avsec_gym.experiments.chapter3.diagrams.variant import (
    Variant,
    is_of_lidar,
    lit,
    with_bogus_object,
)
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import evidence_rows
from avsec_gym.experiments.chapter3.objects.detector_weights import weight_inputs
from avsec_gym.experiments.chapter3.objects.pasted_cars import CarsOfFrames
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    SYSTEM,
    check_parts,
    drives_inputs,
    recordings_of,
    seed_of,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Measurement
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.benign_changes import BENIGN_CHANGES, with_changed_camera
from avsec_gym.validation.evidence.evidence import EVIDENCE_FORMAT
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.recordings import drive_of
from avsec_gym.validation.state_posterior import States, state_vectors

ATTACKED_CAMERAS = (2, 3)
"""Positions of the cameras that are attacked, or changed, in turn: those of the thesis' LiDAR and
two cameras."""
CLEAN = "clean"
POINTS = "bogus points"
"""How many a bogus object has."""
DIAGRAM_FORMAT = 1
"""Raised when something else is measured or kept."""

_WORK = f"{__name__}:DiagramEvidence"
_OBJECTS = "avsec_gym.experiments.chapter3.diagrams.object_cells:DiagramObjects"
_PLACES, _CHANGES = 5, 6
"""Streams of seeds: of the attacks, and of what benign changes draw."""


def diagram_cells(configuration: Configuration) -> list[Cell]:
    """A cell for each frame and matcher, then one for each frame and its objects."""
    check_parts(configuration)
    settings = DiagramSettings.of(configuration)  # An error here comes before the first frame.
    frames = {part: recordings_of(configuration, part).frames for part in (FITTED, JUDGED)}
    kinds = [
        (_WORK, {"matcher": matcher, "evidence": EVIDENCE_FORMAT}) for matcher in settings.depths()
    ]
    kinds += [(_OBJECTS, {})] if settings.believers else []
    return [
        Cell.of(work, drive_of(recorded.id), part=part, number=number, format=DIAGRAM_FORMAT, **own)
        for work, own in kinds
        for part, recordings in frames.items()
        for number, recorded in enumerate(recordings)
    ]


def diagram_inputs(configuration: Configuration) -> dict[str, Path]:
    """Weights, and the manifests of procedural drives."""
    settings = DiagramSettings.of(configuration)
    given = settings.published
    found = {"weights of a published PSMNet": Path(given)} if given else {}
    if settings.believers:
        networks = [*settings.believers, settings.image_detector]
        found |= weight_inputs(networks, settings.weights)
    return found | drives_inputs(configuration, (FITTED, JUDGED))


def fitted_kind(matcher: str, scan: int) -> str:
    """What the evidence of frames to fit on is filed under."""
    return f"{matcher} {FITTED} of {scan}"


def judged_kind(matcher: str, what: str) -> str:
    """What other evidence is filed under: of `Variant.name`, `benign_name` or `clean_name`."""
    return f"{matcher} {what}"


def clean_name(scan: int) -> str:
    """What a frame without an attack is called."""
    return f"{CLEAN} of {scan}"


def benign_name(change: str) -> str:
    """What a frame with one of `BENIGN_CHANGES` is called."""
    return f"benign {change}"


def only(position: int) -> States:
    """The state in which one sensor alone is attacked, shape (1, n + 1)."""
    states = state_vectors(len(SYSTEM))
    return np.asarray(states[[1 << position]])


def camera_of(number: int) -> int:
    """The position of the camera that is attacked in a frame."""
    return ATTACKED_CAMERAS[number % len(ATTACKED_CAMERAS)]


def place_seed(seed: int, number: int) -> tuple[int, int, int]:
    """Seed of the attacks on a judged frame; evidence and objects are of the same ones."""
    return seed, number, _PLACES


class DiagramEvidence:
    """Attacks a frame in every way, and measures the evidence.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        settings = DiagramSettings.of(configuration)
        self._depths, self._scans = settings.depths(), settings.scans
        self._variants = settings.variants()
        self._parts = {part: recordings_of(configuration, part) for part in (FITTED, JUDGED)}
        self._seeds = {part: seed_of(configuration, part) for part in (FITTED, JUDGED)}
        self._cars = CarsOfFrames(self._parts[FITTED].frames)

    def __call__(
        self, part: str, number: int, format: int, matcher: str, evidence: int
    ) -> CellResult:
        """Of a fitted frame the evidence of every state; of a judged one that of each attack.

        Args:
            part: `FITTED` or `JUDGED`.
            number: The number of the frame.
            format: `DIAGRAM_FORMAT`; cells of another one are done again.
            matcher: One of `MATCHERS`.
            evidence: `EVIDENCE_FORMAT`, likewise.
        """
        recorded = self._parts[part].frames[number]
        found = StateEvidence(recorded.frame(), {}, SYSTEM, self._depths[matcher])
        start = time.perf_counter()
        measure = self._fitted if part == FITTED else self._judged
        rows = measure(found, recorded.frame(), matcher, recorded.id, number)
        return CellResult(measurements=rows, seconds={matcher: time.perf_counter() - start})

    def _fitted(
        self, evidence: StateEvidence, frame: SensorFrame, matcher: str, id: str, number: int
    ) -> list[Measurement]:
        seed, every = (self._seeds[FITTED], number), state_vectors(len(SYSTEM))
        tampered = {
            sensor: attacked.frame
            for sensor, attacked in tampered_frames(frame, SYSTEM, FITTED, seed).items()
        }
        scan = tampered.pop(LIDAR)
        evidence = evidence.otherwise(tampered)
        rows = []
        for most in self._scans:
            rings = kept_rings(frame.points, most)
            thinned = scan.with_points(on_rings(scan.points, rings))
            evidence = evidence.with_scan(on_rings(frame.points, rings))
            whole = evidence.attacked_too(LIDAR, thinned)
            rows += evidence_rows(whole, fitted_kind(matcher, most), every, id)
            # The maps of cameras are found once for all scans.
            evidence = whole
        return rows

    def _judged(
        self, evidence: StateEvidence, frame: SensorFrame, matcher: str, id: str, number: int
    ) -> list[Measurement]:
        rows: list[Measurement] = []
        position, seed = camera_of(number), place_seed(self._seeds[JUDGED], number)
        camera = int(SYSTEM.sensors[position])
        for most in self._scans:
            rings = kept_rings(frame.points, most)
            thinned = frame.with_points(on_rings(frame.points, rings))
            evidence = evidence.with_scan(thinned.points)
            none = state_vectors(len(SYSTEM))[:1]
            rows += evidence_rows(evidence, judged_kind(matcher, clean_name(most)), none, id)
            for variant in (each for each in self._variants if each.scan == most):
                kind = judged_kind(matcher, variant.name)
                if not is_of_lidar(variant):
                    changed = lit(variant, thinned, camera, seed)
                    attacked = evidence.otherwise({camera: changed})
                    rows += evidence_rows(attacked, kind, only(position), id)
                    continue
                rows += self._bogus(evidence, thinned, variant, kind, rings, id, number)
            if most == self._scans[0]:
                rows += self._benign(evidence, thinned, matcher, position, id, number)
        return rows

    def _bogus(
        self,
        evidence: StateEvidence,
        frame: SensorFrame,
        variant: Variant,
        kind: str,
        rings: frozenset[int] | None,
        id: str,
        number: int,
    ) -> list[Measurement]:
        car = self._cars.first_of(range(number, number + len(self._parts[FITTED].frames)))
        seed = place_seed(self._seeds[JUDGED], number)
        bogus = with_bogus_object(variant, frame, car, rings, seed)
        if bogus is None:
            return []
        attacked = evidence.otherwise({LIDAR: bogus.tampered.frame})
        assert bogus.tampered.points is not None
        count = float(bogus.tampered.points.sum())
        return [
            *evidence_rows(attacked, kind, only(0), id),
            Measurement(kind, id, POINTS, count),
        ]

    def _benign(
        self,
        evidence: StateEvidence,
        frame: SensorFrame,
        matcher: str,
        position: int,
        id: str,
        number: int,
    ) -> list[Measurement]:
        camera, rows = int(SYSTEM.sensors[position]), []
        for change, happens in BENIGN_CHANGES.items():
            seed = (self._seeds[JUDGED], number, _CHANGES)
            changed = with_changed_camera(frame, camera, happens, seed)
            kind = judged_kind(matcher, benign_name(change))
            rows += evidence_rows(evidence.otherwise({camera: changed}), kind, only(position), id)
        return rows
