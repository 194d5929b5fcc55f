"""Attacks on real frames of KITTI: what three sensors detect, and what detectors are led to see.

Run ``python -m studies.chapter3.real_frames --kitti ROOT --json FILE``. Too few real
frames are at hand to fit thresholds on, so these come from procedural frames of KITTI's own rig;
that a clean real frame stays below them, is shown first.  What detectors are led to see is counted
in the frames that have labels.  `real_frames_page` makes a page of the result.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.attacks import tampered_frames
from avsec_gym.experiments.chapter3.identification.detection_rates import case_name
from avsec_gym.experiments.chapter3.recordings import JUDGED
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS, detect_attack
from avsec_gym.validation.evidence.disparity_error import MEASURES
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.fitting import CleanFrames, fit_threshold_table
from avsec_gym.validation.recordings import object_recordings
from avsec_gym.validation.state_posterior import state_vectors
from avsec_gym.validation.thresholds import Criterion, ThresholdTable
from avsec_gym.world.export import default_suite
from studies.answer import answer
from studies.chapter3.real_frames_result import (
    DetectionOnFrame,
    FittedSuite,
    Measures,
    RealFramesResult,
)
from studies.chapter3.real_impact import impact_on_real_frames

_SYSTEM = LIDAR_AND_TWO_CAMERAS
_TRIPLE = _SYSTEM.triples[0]
_CRITERIA: tuple[Criterion, ...] = ("any", "error")


def run(options: argparse.Namespace) -> RealFramesResult:
    """Fit, and attack every real frame.

    Raises:
        ConfigurationError: No draws.
        DataError: No real frame has both images and a scan.
    """
    if options.draws < 1:
        raise ConfigurationError(f"--draws is 1 or more, got {options.draws}")
    depth = PairDepth("sgbm")
    suite = default_suite("mixed")
    clean = object_recordings(suite, _SYSTEM.sensors).frames
    table = fit_threshold_table(CleanFrames(clean, _SYSTEM, depth, {"suite": "mixed"}))
    real = object_recordings(options.kitti, _SYSTEM.sensors)
    return RealFramesResult(
        fitted=FittedSuite(**table.on.data),
        rate=options.rate,
        draws=options.draws,
        thresholds={
            criterion: _named(table.thresholds(options.rate, criterion)[_TRIPLE].shares)
            for criterion in _CRITERIA
        },
        frames={
            recorded.id: detected(recorded.frame(), table, depth, options.rate, options.draws)
            for recorded in real.frames
        },
        impact=impact_on_real_frames(KittiObject(options.kitti), KittiObject(suite), options.draws),
    )


def detected(
    frame: SensorFrame, table: ThresholdTable, depth: PairDepth, rate: float, draws: int
) -> DetectionOnFrame:
    """What a frame is like without an attack, and how many of the thesis' attacks are detected.

    Args:
        frame: A frame with both images and the scan.
        table: The threshold table.
        depth: The depth that the thresholds hold for.
        rate: The designated false alarm rate r.
        draws: The number of draws of the attacks.
    """
    states = state_vectors(len(_SYSTEM))
    evidence = StateEvidence(frame, {}, _SYSTEM, depth)
    chosen = {criterion: table.thresholds(rate, criterion) for criterion in _CRITERIA}
    sound = evidence.errors(states[0])
    alarms = np.zeros((draws, len(states), len(_CRITERIA)), bool)
    for draw in range(draws):
        tampered = tampered_frames(frame, _SYSTEM, JUDGED, draw)
        evidence = evidence.otherwise(
            {sensor: attacked.frame for sensor, attacked in tampered.items()}
        )
        for number, state in enumerate(states):
            found = evidence.errors(state)
            alarms[draw, number] = [
                detect_attack(found, chosen[criterion]) for criterion in _CRITERIA
            ]
    return DetectionOnFrame(
        clean=_named(sound[_TRIPLE].shares),
        false_alarm={criterion: detect_attack(sound, chosen[criterion]) for criterion in _CRITERIA},
        cases={
            case_name(np.flatnonzero(state).tolist()): {
                criterion: Share.of_counts(int(alarms[:, number, column].sum()), draws)
                for column, criterion in enumerate(_CRITERIA)
            }
            for number, state in enumerate(states)
            if state.any()
        },
    )


def _named(shares: Sequence[float] | np.ndarray) -> Measures:
    return {
        name: round(float(share), 5) if np.isfinite(share) else None
        for name, share in zip(MEASURES, shares, strict=True)
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kitti", type=Path, required=True, help="root of the object benchmark")
    parser.add_argument("--draws", type=int, default=50, help="of the attacks on each frame")
    parser.add_argument("--rate", type=float, default=0.01, help="r")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
