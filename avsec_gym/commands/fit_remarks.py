"""What `avsec validate` reports of the fit that decides: its origin, and what it was fitted on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from avsec_gym.validation.fitted_on import FittedOn
    from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
    from avsec_gym.validation.recordings import RecordedFrame
    from avsec_gym.validation.threshold_validator import ThresholdValidator
    from avsec_gym.validation.validator import Validator


def clean_data(recording: Path, frames: Sequence[RecordedFrame]) -> dict[str, Any]:
    """What names the clean frames of a recording in a fitted file.

    Args:
        recording: Folder of the recording.
        frames: The clean frames, in the recording's order; one or more.
    """
    return {
        "recording": recording.name,
        "root": str(recording.resolve()),
        "first": _full_id(frames[0]),
        "last": _full_id(frames[-1]),
    }


def origin(validator: Validator) -> str:
    """What the validator was fitted on, in words; empty for a validator that is not fitted."""
    fitted = _fitted(validator)
    if fitted is None:
        return ""
    from avsec_gym.validation.shipped import origin_of, stale

    changed = "; the code that measures has changed since" * stale(fitted.on)
    return origin_of(fitted.on) + changed


def remarks(
    validator: Validator, file: Path | None, recording: Path, judged: Sequence[RecordedFrame]
) -> list[str]:
    """What to beware of; some may be empty.

    Args:
        validator: The validator that decides.
        file: File that the options name; None: the fit was made or chosen here.
        recording: Folder of the recording.
        judged: The frames that are judged.
    """
    fitted = _fitted(validator)
    if fitted is None:
        return []
    return [fitted.remark, fitted.vouched, _seen_before(fitted.on, file, recording, judged)]


def fitted_among(data: Mapping[str, Any], recording: Path, frames: Sequence[RecordedFrame]) -> int:
    """How many of some frames a file was fitted on, in a drive or in the day that it is of.

    Args:
        data: What the file reports of its data; of an earlier version, which names no root,
            nothing is known.
        recording: Folder of the recording that the frames belong to.
        frames: Frames to be judged.
    """
    if "root" not in data:
        return 0
    first, second = Path(data["root"]), recording.resolve()
    if first not in (second, *second.parents) and second not in first.parents:
        return 0
    return sum(data["first"] <= _full_id(frame) <= data["last"] for frame in frames)


def _seen_before(
    on: FittedOn, file: Path | None, recording: Path, judged: Sequence[RecordedFrame]
) -> str:
    """A remark where a file was fitted on frames that it is to judge; else nothing."""
    both = fitted_among(on.data, recording, judged)
    if not both:
        return ""
    return (
        f"{both} of the {len(judged)} frames were among those that {file} was made of: that they "
        "raise no alarm means little"
    )


def _fitted(validator: Validator) -> ThresholdValidator | LikelihoodValidator | None:
    """The validator, if it is one of those that are fitted; of others nothing is known."""
    from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
    from avsec_gym.validation.threshold_validator import ThresholdValidator

    if isinstance(validator, ThresholdValidator | LikelihoodValidator):
        return validator
    return None


def _full_id(frame: RecordedFrame) -> str:
    """With the drive's name, also where there is but one drive."""
    if frame.drive is None or "/" in frame.id:
        return frame.id
    return f"{frame.drive}/{frame.id}"
