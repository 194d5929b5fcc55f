"""What shipped thresholds and likelihoods are worth: on other procedural drives, and for real.

Run ``python -m studies.chapter3.shipped_fits.judge --json FILE``, ``--kitti`` for
real frames; `page` makes a page.  Judged are drives that nothing was fitted on, clean
and under the thesis' attacks; of real frames those that have both images and a scan.  Of real pairs
of images one share is known without a scan, which is compared with its threshold.
"""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.attacks import tampered_frames
from avsec_gym.experiments.chapter3.recordings import JUDGED
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.validation.evidence.disparity_error import MEASURES
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.fitting import KeptSample
from avsec_gym.validation.identification import identify_attacked_sensors
from avsec_gym.validation.likelihood.maximum_likelihood import (
    LikelihoodModel,
    read_likelihood_model,
)
from avsec_gym.validation.recordings import RecordedFrame, object_recordings, raw_recordings
from avsec_gym.validation.shipped import (
    FITS,
    SHIPPED_SYSTEMS,
    origin_of,
    shipped_file,
    shipped_fit,
)
from avsec_gym.validation.state_posterior import SensorStatus, States, state_vectors
from avsec_gym.validation.thresholds import ThresholdTable, read_threshold_table
from studies.answer import answer
from studies.chapter3.shipped_fits.evidence import (
    SYSTEM,
    SystemEvidence,
    evidence_of,
    measured,
    sample_id,
    shipped_drives,
)
from studies.chapter3.shipped_fits.judged_result import (
    JudgedCase,
    JudgedFits,
    JudgedRealFrames,
    JudgedSystem,
)

NO_ATTACK = "no attack"
CERTAINTY = 0.95
"""The certainty as `LikelihoodValidator` has it."""
_OBJECT = SensorSystem((LIDAR, 3, 2))
_PAIR = (1, 2)
"""Cameras 3 and 2 of it."""
_LOG = logging.getLogger(__name__)

Said = tuple[NDArray[np.bool_], list[frozenset[int]] | None]
"""Alarms, shape (N,), and the positions of the sensors that are named; None: none ever can be."""


def run(options: argparse.Namespace) -> JudgedFits:
    """Judge procedural drives, and real frames if there are any.

    Raises:
        ConfigurationError: No frames or draws; or a shipped file does not hold for the frames.
        DataError: A shipped file is not there, or no real frame has both images and a scan.
    """
    if min(options.frames, options.draws) < 1:
        raise ConfigurationError("--frames and --draws are 1 or more")
    root = shipped_drives(options.frames, options.seed, JUDGED)
    kept = JsonLines(options.samples, KeptSample)
    frames = raw_recordings(root, SYSTEM.sensors).frames[: options.frames]
    depth = PairDepth("sgbm")
    rows = []
    for number, recorded in enumerate(frames):
        seeds = [(options.seed, number)]
        rows.append(attacked_in_turn_rows(recorded, SYSTEM, depth, kept, seeds)[0])
        _LOG.info("measured %d of %d frames", number + 1, len(frames))
    every = evidence_of(np.array(rows), SYSTEM, one_at_a_time(SYSTEM))
    frame = frames[0].frame()
    return JudgedFits(
        rate=options.rate,
        seed=options.seed,
        frames=len(frames),
        systems=[
            judged(every.of(system), frame, options.rate, options.fits)
            for system in SHIPPED_SYSTEMS
        ],
        real=None if options.kitti is None else _real(options, depth, kept),
    )


def one_at_a_time(system: SensorSystem) -> States:
    """No attack, then each sensor attacked alone."""
    states = state_vectors(len(system))
    return np.asarray(states[states.sum(axis=1) <= 1])


def attacked_in_turn_rows(
    recorded: RecordedFrame,
    system: SensorSystem,
    depth: PairDepth,
    kept: JsonLines,
    seeds: Iterable[tuple[int, int]],
) -> Floats:
    """The evidence of a frame, see `measured`, clean and with each sensor attacked in turn.

    Args:
        recorded: The frame.
        system: The sensors.
        depth: How disparities are found.
        kept: What was measured before, which is not measured again.
        seeds: Seeds of the attacks.

    Returns:
        Of each seed, shape (seeds, n + 2, any).
    """
    rows, clean = [], None
    for seed in seeds:
        sensors = " ".join(map(str, system.sensors))
        id = sample_id(f"{recorded.id} {sensors} {seed[1]}", seed[0], JUDGED)
        if id not in kept.rows:
            frame = recorded.frame()
            clean = clean or StateEvidence(frame, {}, system, depth)
            tampered = tampered_frames(frame, system, JUDGED, seed)
            evidence = clean.otherwise(
                {sensor: attacked.frame for sensor, attacked in tampered.items()}
            )
            found = measured(evidence, one_at_a_time(system))
            kept.add({"id": id, "measured": found.tolist()})
            # What is known of the clean frame stays known.
            clean = evidence
        rows.append(kept.rows[id]["measured"])
    return np.array(rows)


def judged(evidence: SystemEvidence, frame: SensorFrame, rate: float, fits: Path) -> JudgedSystem:
    """How often there is an alarm, and exactly the attacked sensors are named, case by case.

    Args:
        evidence: Evidence in the states of `one_at_a_time`.
        frame: A frame of the rig.
        rate: The designated false alarm rate r.
        fits: Folder of the files.
    """
    system, depth = evidence.system, PairDepth("sgbm")
    table = read_threshold_table(shipped_fit("thresholds", system, depth, frame, fits))
    model = read_likelihood_model(shipped_fit("likelihood", system, depth, frame, fits))
    by: dict[str, dict[str, JudgedCase]] = {"thresholds": {}, "likelihood": {}}
    for number, state in enumerate(evidence.states):
        attacked = frozenset(np.flatnonzero(state).tolist())
        case = ", ".join(str(system.sensors[position]) for position in attacked) or NO_ATTACK
        for name, (alarms, named) in {
            "thresholds": said_by_thresholds(table, evidence.shares[:, number], rate),
            "likelihood": said_by_likelihood(model, evidence.elements[:, number], rate),
        }.items():
            by[name][case] = JudgedCase(
                alarms=_share(alarms),
                named=None if named is None else _share([sensors == attacked for sensors in named]),
            )
    return JudgedSystem(system.sensors, origin_of(table.on), by)


def said_by_thresholds(table: ThresholdTable, shares: Floats, rate: float) -> Said:
    """What `ThresholdValidator` reports of N frames.

    Args:
        table: The threshold table.
        shares: Shares of every triple, shape (N, triples, 4).
        rate: The designated false alarm rate r.
    """
    system, chosen = table.on.system, table.thresholds(rate)
    limits = np.array([chosen[triple].shares for triple in system.triples])
    beyond = np.asarray((shares > limits).any(axis=2))
    if len(system) == 3:
        return beyond[:, 0], None
    found = [
        identify_attacked_sensors(
            dict(zip(system.triples, row, strict=True)).__getitem__, len(system)
        )
        for row in beyond.tolist()
    ]
    alarms = np.array([bool(answer.named or answer.doubtful) for answer in found])
    return alarms, [frozenset(answer.named) for answer in found]


def said_by_likelihood(model: LikelihoodModel, elements: Floats, rate: float) -> Said:
    """What `LikelihoodValidator` reports of N frames.

    Args:
        model: The model of likelihoods.
        elements: Shape (N, M).
        rate: The designated false alarm rate r.
    """
    decoding = model.decode(elements, rate)
    statuses = decoding.statuses(CERTAINTY)
    named = [
        frozenset(i for i, status in enumerate(own) if status == SensorStatus.ATTACKED)
        for own in statuses
    ]
    return decoding.alarms, named


def _real(options: argparse.Namespace, depth: PairDepth, kept: JsonLines) -> JudgedRealFrames:
    """Frames with both images and a scan, each attacked `draws` times; and pairs of images."""
    frames = {}
    for recorded in object_recordings(options.kitti, _OBJECT.sensors).frames:
        seeds = [(options.seed, draw) for draw in range(options.draws)]
        rows = attacked_in_turn_rows(recorded, _OBJECT, depth, kept, seeds)
        evidence = evidence_of(rows, _OBJECT, one_at_a_time(_OBJECT))
        system = judged(evidence, recorded.frame(), options.rate, options.fits)
        # Without an attack all draws are the same frame.
        by = {
            name: {**cases, NO_ATTACK: _once(cases[NO_ATTACK], options.draws)}
            for name, cases in system.by.items()
        }
        clean = _measures(evidence.shares[0, 0, 0])
        frames[recorded.id] = replace(system, by=by, clean=clean)
    table = read_threshold_table(shipped_file("thresholds", _OBJECT, options.fits))
    thresholds = table.thresholds(options.rate)[_OBJECT.triples[0]]
    return JudgedRealFrames(
        draws=options.draws,
        frames=frames,
        thresholds=_measures(thresholds.shares),
        pairs=_pairs(options.kitti, depth),
    )


def _once(clean: JudgedCase, draws: int) -> JudgedCase:
    """Of one frame that was judged several times."""
    return JudgedCase(_share([clean.alarms.count >= draws]), None)


def _pairs(kitti: Path, depth: PairDepth) -> dict[str, float]:
    """Other brightness of cameras 3 and 2, of each real frame with both images."""
    data = KittiObject(kitti)
    return {
        id: round(DisparityMaps(data.frame(id), _OBJECT, depth).brightness(_PAIR).patches, 6)
        for id in data.ids(having=("image_2", "image_3", "calib"))
    }


def _measures(shares: Floats) -> Mapping[str, float]:
    return {name: round(float(share), 6) for name, share in zip(MEASURES, shares, strict=True)}


def _share(hits: ArrayLike) -> Share:
    return Share.of_counts(int(np.sum(hits)), np.size(hits))


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--frames", type=int, default=100, help="procedural ones to judge")
    parser.add_argument("--seed", type=int, default=0, help="of the drives and of the attacks")
    parser.add_argument("--rate", type=float, default=0.01, help="r")
    parser.add_argument("--draws", type=int, default=50, help="of the attacks on each real frame")
    parser.add_argument("--kitti", type=Path, help="root of the object benchmark")
    parser.add_argument("--fits", type=Path, default=FITS, help="folder of what is judged")
    parser.add_argument("--samples", type=Path, default=Path("runs/shipped_fits/judged.jsonl"))
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    return answer(parser.parse_args(arguments), run)


if __name__ == "__main__":
    sys.exit(main())
