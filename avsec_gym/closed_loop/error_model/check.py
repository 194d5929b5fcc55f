"""Hold an error model against frames that it was not fitted to.

The margins are set beforehand, and the answer is one of three: a difference whose 95 % interval
lies within the margin agrees, one whose interval lies outside of it differs, and of any other one
cannot tell.  An interval is over drives, all vehicles of a drive together; what a model expects is
taken as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from avsec_gym.closed_loop.error_model.fit import Compared, DetectedFrame, compared
from avsec_gym.closed_loop.error_model.model import ErrorModel
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import share_of

RANGES = ((0.0, 15.0), (15.0, 30.0), (30.0, 60.0))
"""Distances in metres for which misses and ghosts are compared."""
FOUND_MARGIN = 0.1
"""How far the share of found objects may lie from the model's."""
GHOST_MARGIN = 0.1
"""How far the number of ghosts in a frame may lie from the model's."""


class Agreement(StrEnum):
    """Whether a model does as its detector does."""

    AGREES = "agrees"
    DIFFERS = "differs"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True)
class RangeCheck:
    """Misses and ghosts between two distances, as seen and as the model has them.

    Args:
        near: Least distance, metres.
        far: Greatest distance, metres.
        objects: Number of objects.
        found: Share of them that was found; None: there are no objects.
        found_interval: 95 % interval of it; frames of a drive count as one cluster.
        found_expected: Share that the model expects.
        ghosts: Mean number of ghosts in a frame.
        ghosts_error: Standard error of it, over drives; taken, as in `share_of`, as if two more had
            been seen, one without ghosts and one with a ghost in each frame.
        ghosts_expected: Mean number that the model expects.
    """

    near: float
    far: float
    objects: int
    found: float | None
    found_interval: tuple[float, float] | None
    found_expected: float | None
    ghosts: float
    ghosts_error: float
    ghosts_expected: float

    @property
    def answer(self) -> Agreement:
        """The answer of misses and ghosts together: both have to agree, and either may differ."""
        ghosts, error = self.ghosts - self.ghosts_expected, 2 * self.ghosts_error
        answers = {_answer(ghosts - error, ghosts + error, GHOST_MARGIN)}
        if self.found_expected is None or self.found_interval is None:
            answers.add(Agreement.CANNOT_TELL)
        else:
            low, high = (bound - self.found_expected for bound in self.found_interval)
            answers.add(_answer(low, high, FOUND_MARGIN))
        if Agreement.DIFFERS in answers:
            return Agreement.DIFFERS
        return Agreement.AGREES if answers == {Agreement.AGREES} else Agreement.CANNOT_TELL


def check_error_model(model: ErrorModel, frames: Sequence[DetectedFrame]) -> list[RangeCheck]:
    """Compare a model with frames, distance by distance.

    Args:
        model: An error model.
        frames: Frames of the same detector under the same attack; none that it was fitted to.
    """
    every = [compared(frame) for frame in frames]
    return [_range_check(model, every, *limits) for limits in RANGES]


def _range_check(
    model: ErrorModel, every: Sequence[Compared], near: float, far: float
) -> RangeCheck:
    hits: list[bool] = []
    drives: list[str] = []
    expected: list[float] = []
    ghosts: dict[str, list[int]] = {}
    for each in every:
        inside = (each.views.distance >= near) & (each.views.distance < far)
        hits += each.found[inside].tolist()
        drives += [each.frame.drive] * int(inside.sum())
        expected += model.probabilities(each.objects, each.views)[inside].tolist()
        away = _distances(each.detections[each.matches.ghosts].poses)
        ghosts.setdefault(each.frame.drive, []).append(int(((away >= near) & (away < far)).sum()))
    share = share_of(hits, drives)
    means = [0.0, 1.0, *(float(np.mean(counts)) for counts in ghosts.values())]
    seen = np.reshape(model.ghosts.seen, (-1, 6))
    inside = (_distances(seen) >= near) & (_distances(seen) < far)
    return RangeCheck(
        near,
        far,
        len(hits),
        share.rate,
        share.interval,
        float(np.mean(expected)) if expected else None,
        float(np.mean([count for counts in ghosts.values() for count in counts])),
        float(np.std(means) / np.sqrt(len(means) - 1)),
        model.ghosts.rate * (float(inside.mean()) if len(seen) else 0.0),
    )


def _answer(low: float, high: float, margin: float) -> Agreement:
    """By the interval of a difference."""
    if low > margin or high < -margin:
        return Agreement.DIFFERS
    return Agreement.AGREES if -margin <= low and high <= margin else Agreement.CANNOT_TELL


def _distances(poses: Floats) -> Floats:
    return np.hypot(poses[:, 0], poses[:, 1])
