"""Makes the thresholds and likelihoods that the package ships.

Run ``python -m studies.chapter3.shipped_fits.fit --out avsec_gym/validation/fits``.
Drives are rendered once, into the cache; what was measured is kept in ``--samples``, and a run that
was stopped goes on there.
"""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from avsec_gym.attacks.attacks_to_fit_on import attack_to_fit_on, attacked_in_turn
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.recordings import FITTED
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.evidence.state_evidence import StateEvidence
from avsec_gym.validation.fitting import KeptSample
from avsec_gym.validation.likelihood.likelihood_of_clean import likelihood_of_clean
from avsec_gym.validation.recordings import raw_recordings
from avsec_gym.validation.shipped import FITS, SHIPPED_SYSTEMS, shipped_file, shipped_on
from avsec_gym.validation.state_posterior import state_vectors
from avsec_gym.validation.thresholds import ThresholdTable
from avsec_gym.world.export import world_fingerprint
from studies.answer import exit_code
from studies.chapter3.shipped_fits.evidence import (
    PART_ASSETS,
    SYSTEM,
    evidence_of,
    measured,
    sample_id,
    shipped_drives,
)

USUAL_FRAMES = 300
_LEAST_FRAMES = 100
"""Thresholds at r = 1 % are order statistics of so many or more."""
_LOG = logging.getLogger(__name__)


def write_fits(frames: int, seed: int, samples: Path, out: Path) -> None:
    """Measure, fit, and write a file of thresholds and one of likelihoods for each system.

    Args:
        frames: The number of frames, of as many drives.
        seed: Seed of the drives, and of the attacks on them.
        samples: What is measured of each frame, a line each.
        out: Folder of the files, which are written over.

    Raises:
        ConfigurationError: Too few frames.
        DataError: A file cannot be written, or `samples` is damaged.
    """
    if frames < _LEAST_FRAMES:
        raise ConfigurationError(f"it takes {_LEAST_FRAMES} frames or more, got {frames}")
    root = shipped_drives(frames, seed, FITTED)
    drawn = raw_recordings(root, SYSTEM.sensors).frames[:frames]
    kept, depth = JsonLines(samples, KeptSample), PairDepth("sgbm")
    for number, recorded in enumerate(drawn):
        if (id := sample_id(recorded.id, seed, FITTED)) not in kept.rows:
            row = fitted_row(recorded.frame(), depth, seed, number)
            kept.add({"id": id, "measured": row.tolist()})
            _LOG.info("measured %d of %d frames", number + 1, frames)
    rows = np.array(
        [kept.rows[sample_id(recorded.id, seed, FITTED)]["measured"] for recorded in drawn]
    )
    every, frame = evidence_of(rows, SYSTEM), drawn[0].frame()
    data = {
        "seed": seed,
        "frames": frames,
        "drives": frames,
        "assets": str(PART_ASSETS[FITTED]),
        "world": world_fingerprint(),
    }
    for system in SHIPPED_SYSTEMS:
        own, on = every.of(system), shipped_on(system, depth, frame, data)
        table = ThresholdTable(on, own.shares[:, 0])
        table.write(shipped_file("thresholds", system, out), overwrite=True)
        names = [recorded.drive or recorded.id for recorded in drawn]
        model = likelihood_of_clean(on, own.elements, names)
        model.write(shipped_file("likelihood", system, out), overwrite=True)


def fitted_row(frame: SensorFrame, depth: PairDepth, seed: int, number: int) -> Floats:
    """The evidence of a frame to fit on in every state, see `measured`.

    Args:
        frame: A frame without an attack.
        depth: How disparities are found.
        seed: Seed of the fit.
        number: The number of the frame.
    """
    attack_of = partial(attack_to_fit_on, reference=SYSTEM.reference)
    tampered = attacked_in_turn(frame, SYSTEM, attack_of, (seed, number))
    frames = {sensor: attacked.frame for sensor, attacked in tampered.items()}
    return measured(StateEvidence(frame, frames, SYSTEM, depth), state_vectors(len(SYSTEM)))


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--frames", type=int, default=USUAL_FRAMES, help="to fit on")
    parser.add_argument("--seed", type=int, default=0, help="of the drives and of the attacks")
    parser.add_argument("--out", type=Path, default=FITS, help="folder of the files")
    parser.add_argument(
        "--samples", type=Path, default=Path("runs/shipped_fits/samples.jsonl"),
        help="what was measured of each frame",
    )  # fmt: skip
    options = parser.parse_args(arguments)
    return exit_code(lambda: write_fits(options.frames, options.seed, options.samples, options.out))


if __name__ == "__main__":
    sys.exit(main())
