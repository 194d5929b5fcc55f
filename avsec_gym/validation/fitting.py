"""Fits what a validator decides by to clean frames: thresholds, or a likelihood model.

What is measured of each frame can be kept in a file, so that a fit that was stopped goes on with
the next frame.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, TypedDict

import numpy as np

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.progress import Progress
from avsec_gym.sensor_system import SensorSystem
from avsec_gym.storage.json_lines import JsonLines
from avsec_gym.validation.evidence.disparity_error import MEASURES
from avsec_gym.validation.evidence.evidence import evidence_scopes
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import FittedOn, fitted_on
from avsec_gym.validation.likelihood.likelihood_of_clean import (
    evidence_of_all_states,
    likelihood_of_clean,
)
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.recordings import RecordedFrame
from avsec_gym.validation.thresholds import ThresholdTable, shares_of


@dataclass(frozen=True)
class CleanFrames:
    """Frames of one rig that were recorded without an attack.

    Args:
        frames: The frames, in the order in which they were recorded.
        system: The sensors of the rig.
        depth: How disparities of two cameras are found.
        data: What names the frames in the fitted file; JSON-able.
        leaves_out_broken: Whether a frame whose files are broken is left out, and named with the
            reason in the fit's data; else it is an error.
    """

    frames: Sequence[RecordedFrame]
    system: SensorSystem
    depth: PairDepth
    data: Mapping[str, Any] = field(default_factory=dict)
    leaves_out_broken: bool = False


def fit_threshold_table(
    clean: CleanFrames, *, samples: Path | None = None, on_progress: Progress | None = None
) -> ThresholdTable:
    """Measure the disparity errors of clean frames, whence thresholds follow (section 3.3.2).

    Args:
        clean: One frame or more.
        samples: File of this fit alone that keeps what is measured; None: nothing is kept.
        on_progress: Callback after each frame.

    Raises:
        ConfigurationError: There is no frame, or none that is whole.
        DataError: A frame's file is broken and it is not left out; or `samples` is damaged.
    """
    measured = _measured(
        clean,
        lambda _, frame: shares_of(frame, clean.system, clean.depth),
        (len(clean.system.triples), len(MEASURES)),
        samples,
        on_progress,
    )
    return ThresholdTable(measured.on, measured.values)


def fit_likelihood_model(
    clean: CleanFrames,
    seed: int,
    *,
    samples: Path | None = None,
    on_progress: Progress | None = None,
) -> LikelihoodModel:
    """Attack clean frames in every way, and fit the likelihoods of what the sensors then report.

    Args:
        clean: Ten frames or more.
        seed: Seed of the attacks, which are those of `attack_to_fit_on`.
        samples: The folder of samples, see `fit_threshold_table`.
        on_progress: Callback after each frame; the fit itself takes a minute beyond the last.

    Raises:
        ConfigurationError: There are fewer than ten whole frames.
        DataError: As of `fit_threshold_table`.
    """
    measured = _measured(
        clean,
        lambda number, frame: evidence_of_all_states(
            frame, clean.system, clean.depth, (seed, number)
        ),
        (2 ** len(clean.system), len(evidence_scopes(clean.system))),
        samples,
        on_progress,
    )
    drives = [frame.drive or frame.id for frame in measured.frames]
    return likelihood_of_clean(measured.on, measured.values, drives)


class KeptSample(TypedDict):
    """What is kept of a frame: shares, a list for each triple of sensors or for each state."""

    id: str
    measured: list[list[float]]


class _Measured(NamedTuple):
    """The measurements of the frames that are whole."""

    frames: list[RecordedFrame]
    values: Floats
    """A row for each frame."""
    on: FittedOn


def _measured(
    clean: CleanFrames,
    measure: Callable[[int, SensorFrame], Floats],
    shape: tuple[int, int],
    samples: Path | None,
    on_progress: Progress | None,
) -> _Measured:
    """Measure the frames that an earlier run did not.

    Args:
        clean: The frames.
        measure: Function of a frame's number, which stays the same when a run goes on, and of what
            its sensors deliver.
        shape: The shape of what it returns.
        samples: A line for each frame.
        on_progress: Callback after each frame.
    """
    kept, left_out = JsonLines(samples, KeptSample), dict[str, str]()
    check_samples(kept.rows, shape, samples)
    # Numbers count all frames: seeds do not depend on what was measured before.
    missing = [
        (n, recorded) for n, recorded in enumerate(clean.frames) if recorded.id not in kept.rows
    ]
    for done, (number, recorded) in enumerate(missing, start=1):
        try:
            values = measure(number, recorded.read(clean.system))
        except DataError as error:
            if not clean.leaves_out_broken:
                raise
            left_out[recorded.id] = str(error)
        else:
            kept.add({"id": recorded.id, "measured": values.tolist()})
        if on_progress is not None:
            on_progress(done, len(missing))
    whole = [recorded for recorded in clean.frames if recorded.id in kept.rows]
    if not whole:
        reasons = "".join(f": {reason}" for reason in list(left_out.values())[:1])
        raise ConfigurationError(f"there are no clean frames to fit on{reasons}")
    data = {**clean.data, "frames": len(whole)}
    if clean.leaves_out_broken:
        data["left_out"] = left_out
    on = fitted_on(clean.system, clean.depth, whole[0].frame().calibration, data)
    return _Measured(
        whole, np.array([kept.rows[recorded.id]["measured"] for recorded in whole]), on
    )


def check_samples(
    rows: Mapping[str, Mapping[str, Any]], shape: tuple[int, int], path: Path | None
) -> None:
    """Raise DataError where a kept row is not what these sensors measure."""
    for id, row in rows.items():
        measured = row["measured"]
        fitting = len(measured) == shape[0] and all(len(shares) == shape[1] for shares in measured)
        if not fitting or not all(0 <= share <= 1 for shares in measured for share in shares):
            raise DataError(
                f"The row of {id!r:.60} does not hold {shape[0]} x {shape[1]} shares from 0 to 1.",
                path=path,
                remedy="Take the line out: its frame is then measured again.",
            )
