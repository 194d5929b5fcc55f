"""Adaptive attacks, which stay where the method does not look: the work of `adaptive_attacks`.

Each kind goes around one of the rules by which sensors are compared.  What it is worth to the
attacker is another question: a dim facula hides as little as it shows.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from avsec_gym.attacks.attack import Seed
from avsec_gym.attacks.facula import THESIS_RADII, Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import evidence_rows
from avsec_gym.experiments.chapter3.recordings import JUDGED, OPTIONS, frame_cells, recordings_of
from avsec_gym.frame import SensorFrame
from avsec_gym.runs.experiment import Cell, CellResult, Configuration
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem
from avsec_gym.validation.evidence.brightness import MIN_LIGHT
from avsec_gym.validation.evidence.evidence import EVIDENCE_FORMAT
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.state_posterior import States

Tampered = dict[Sensor, TamperedFrame]
"""The frame with one sensor attacked at a time."""
Tamper = Callable[[SensorFrame, SensorSystem, Seed], Tampered]
"""How a frame is attacked."""

DIM, VEIL, AGREEING = "dim", "veil", "agreeing"
FAR, REMOVED, OUT_OF_SIGHT = "far", "removed", "out of sight"
AGREED_DEPTH = 12.0
"""Metres; light that is at the same place of this plane in all images, is on it for the cameras."""
_VEIL_RADIUS, _VEIL_STRENGTH = 1e5, 64.0
"""Pixels, grey levels: the same light everywhere, as another exposure has."""
_STREAM = 6
"""The stream of draws; the other experiments of chapter 3 have those below."""
_WORK = f"{__name__}:AdaptiveAttacks"


class AdaptiveAttack(NamedTuple):
    """One way around the rules."""

    attacked: tuple[tuple[int, ...], ...]
    """Sets of positions in the system that are attacked together."""
    tamper: Tamper
    """Attacks a frame."""


def adaptive_cells(configuration: Configuration) -> list[Cell]:
    """A cell for every judged frame."""
    return frame_cells(_WORK, configuration, (JUDGED,), format=EVIDENCE_FORMAT)


class AdaptiveAttacks:
    """Attacks a frame in every way of `KINDS`, and asks for the evidence.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._depth = PairDepth({**OPTIONS, **configuration.options}["depth"])
        self._recordings = recordings_of(configuration, JUDGED)
        self._seed = configuration.seed

    def __call__(self, part: str, number: int, format: int) -> CellResult:
        """The evidence of each kind, under each set of attacked sensors.

        Args:
            part: The part of the run: `JUDGED`.
            number: The number of the frame.
            format: `EVIDENCE_FORMAT` of what is measured; cells of another one are done again.
        """
        recorded, system = self._recordings.frames[number], self._recordings.system
        frame = recorded.frame()
        evidence = StateEvidence(frame, {}, system, self._depth)
        rows, start = [], time.perf_counter()
        for stream, (name, kind) in enumerate(KINDS.items()):
            tampered = kind.tamper(frame, system, (self._seed, number, _STREAM, stream))
            evidence = evidence.otherwise(
                {sensor: attacked.frame for sensor, attacked in tampered.items()}
            )
            rows += evidence_rows(evidence, name, states_of(kind, len(system)), recorded.id)
        return CellResult(measurements=rows, seconds={"evidence": time.perf_counter() - start})


def states_of(kind: AdaptiveAttack, sensors: int) -> States:
    """Its sets as sensor state vectors, shape (sets, n + 1)."""
    states = np.zeros((len(kind.attacked), sensors), bool)
    for state, attacked in zip(states, kind.attacked, strict=True):
        state[list(attacked)] = True
    return states


def agreeing_faculae(frame: SensorFrame, system: SensorSystem, seed: Seed) -> Tampered:
    """The same light in all cameras, each shifted as a surface at `AGREED_DEPTH` is."""
    reference, calibration = system.reference, frame.calibration
    drawn = Facula(reference, THESIS_RADII).attack(frame, seed).settings
    result: Tampered = {}
    for camera in system.cameras:
        shift = calibration.focal_length(camera) * calibration.baseline(reference, camera)
        centre = (drawn["u"] - shift / AGREED_DEPTH, drawn["v"])
        result[camera] = Facula(camera, drawn["radius"], centre).attack(frame, seed)
    return result


def removed_returns(frame: SensorFrame, system: SensorSystem, seed: Seed) -> Tampered:
    """A scan that lacks all that is behind a patch, which itself is not there."""
    hidden = LidarSpoofing(rays_lost=True, reference=system.reference).attack(frame, seed)
    kept = hidden.frame.points[~hidden.points] if hidden.points is not None else frame.points
    return {LIDAR: replace(hidden, frame=frame.with_points(kept), points=None)}


def _lit(facula: Facula) -> Tamper:
    """One camera at a time, each somewhere else."""

    def tamper(frame: SensorFrame, system: SensorSystem, seed: Seed) -> Tampered:
        return {
            camera: replace(facula, camera=camera).attack(frame, [*np.atleast_1d(seed), camera])
            for camera in system.cameras
        }

    return tamper


def _spoofed(spoofing: LidarSpoofing) -> Tamper:
    """The LiDAR."""

    def tamper(frame: SensorFrame, system: SensorSystem, seed: Seed) -> Tampered:
        return {LIDAR: replace(spoofing, reference=system.reference).attack(frame, seed)}

    return tamper


_CAMERAS = ((1,), (2,), (3,))
KINDS: Mapping[str, AdaptiveAttack] = {
    DIM: AdaptiveAttack(_CAMERAS, _lit(Facula(strength=MIN_LIGHT - 1))),
    VEIL: AdaptiveAttack(_CAMERAS, _lit(Facula(radius=_VEIL_RADIUS, strength=_VEIL_STRENGTH))),
    AGREEING: AdaptiveAttack(((2, 3), (1, 2, 3)), agreeing_faculae),
    FAR: AdaptiveAttack(((0,),), _spoofed(LidarSpoofing(distance=(20.0, 30.0)))),
    REMOVED: AdaptiveAttack(((0,),), removed_returns),
    OUT_OF_SIGHT: AdaptiveAttack(((0,),), _spoofed(LidarSpoofing(bearing=math.pi / 2))),
}
"""Light below `MIN_LIGHT`; the same light everywhere; the same light in several cameras, where one
surface would be; bogus returns far ahead; returns taken away; bogus returns beside the images."""
