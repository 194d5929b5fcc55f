"""Which frames `avsec validate` judges, and by what: clean ones of the same recording, or a file.

A recording with 1 / r clean frames or more is judged by a fit on these; one with fewer by what the
package ships, if that is of such a rig, and the output states where the fit comes from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from avsec_gym.errors import ConfigurationError, DataError

if TYPE_CHECKING:
    from avsec_gym.frame import SensorFrame
    from avsec_gym.validation.evidence.pair_depth import PairDepth
    from avsec_gym.validation.recordings import RecordedFrame, Recordings
    from avsec_gym.validation.shipped import FitKind

USUAL_SHARE = 0.25
"""The share of the frames that are fitted on."""


@dataclass(frozen=True)
class JudgedBy:
    """Frames to be judged, and what they are judged by.

    Args:
        judged: The frames to be judged, one or more.
        clean: Frames of the same recording without an attack, to fit on; empty where a file is
            there.
        shipped: The package's own file; None where it is not needed.
        remark: Why a file of the package's own is not used where few frames are clean; or empty.
    """

    judged: Sequence[RecordedFrame]
    clean: Sequence[RecordedFrame] = ()
    shipped: Path | None = None
    remark: str = ""


def judged_by_clean(recordings: Recordings, ids: Sequence[str], share: float) -> JudgedBy:
    """Fit on the first frames, judge the others, or those that are named.

    Args:
        recordings: The recorded frames.
        ids: The ids of the frames to be judged; none is fitted on. Empty: all that are not fitted
            on.
        share: The share of all frames that is fitted on.

    Raises:
        ConfigurationError: None is left to fit on, or to be judged.
        DataError: An id that is not there.
    """
    named, frames = recordings.named(ids), recordings.frames
    others = [recorded for recorded in frames if recorded.id not in set(ids)]
    count = max(1, round(share * len(frames)))
    clean, judged = others[:count], named or others[count:]
    if not clean or not judged:
        raise ConfigurationError(
            f"of {len(frames)} frames none is left to be {'judged' if clean else 'fitted on'}: "
            "lower --clean, raise --limit, or give --thresholds or --likelihood of an earlier run"
        )
    return JudgedBy(judged, clean)


def judged_by_shipped(
    recordings: Recordings, ids: Sequence[str], kind: FitKind, depth: PairDepth
) -> JudgedBy:
    """Judge all frames, or those that are named, by what the package ships.

    Args:
        recordings: The recorded frames.
        ids: The ids of the frames, see `judged_by_clean`.
        kind: The kind of the file.
        depth: How disparities of two cameras are found.

    Raises:
        ConfigurationError: Nothing is shipped for such sensors, such a rig or such depth.
        DataError: An id that is not there; or no frame's image can be read.
    """
    from avsec_gym.validation.shipped import shipped_fit

    judged = recordings.named(ids) or recordings.frames
    frame = _first_readable(judged, recordings.system.reference)
    return JudgedBy(judged, shipped=shipped_fit(kind, recordings.system, depth, frame))


def judged_by_enough(
    recordings: Recordings, ids: Sequence[str], rate: float, depth: PairDepth
) -> JudgedBy:
    """Fit on the usual share of the frames if it is 1 / r or more; else by thresholds shipped.

    Args:
        recordings: The recorded frames.
        ids: The ids of the frames, see `judged_by_clean`.
        rate: The designated false alarm rate r.
        depth: How disparities of two cameras are found.

    Raises:
        ConfigurationError: Neither can be.
        DataError: As above.
    """
    refused: ConfigurationError | None = None
    own: JudgedBy | None = None
    try:
        own = judged_by_clean(recordings, ids, USUAL_SHARE)
    except ConfigurationError as error:
        refused = error
    if own is not None and rate * len(own.clean) >= 1:
        return own
    try:
        return judged_by_shipped(recordings, ids, "thresholds", depth)
    except ConfigurationError as error:
        if own is None:
            raise ConfigurationError(f"{refused}; {error}") from error
        return JudgedBy(own.judged, own.clean, remark=str(error))


def _first_readable(frames: Sequence[RecordedFrame], camera: int) -> SensorFrame:
    """The first frame whose image can be read."""
    problems = []
    for recorded in frames:
        try:
            frame = recorded.frame()
            frame.image(camera)
        except DataError as error:
            problems.append(error)
        else:
            return frame
    raise problems[0]
