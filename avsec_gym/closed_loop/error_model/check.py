"""Hold an error model against frames that it was not fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.closed_loop.error_model.fit import Compared, DetectedFrame, compared
from avsec_gym.closed_loop.error_model.model import ErrorModel
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import share_of

RANGES = ((0.0, 15.0), (15.0, 30.0), (30.0, 60.0))
"""Distances in metres for which misses and ghosts are compared."""
FOUND_MARGIN = 0.1
"""A share of found objects agrees within this, or within its interval."""
GHOST_MARGIN = 0.1
"""A number of ghosts in a frame agrees within this, or within two standard errors."""


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
        ghosts_error: Standard error of it, over drives.
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
    def agrees(self) -> bool:
        """Whether misses and ghosts both lie within their margins."""
        by_ghosts = abs(self.ghosts - self.ghosts_expected)
        if by_ghosts > max(GHOST_MARGIN, 2 * self.ghosts_error):
            return False
        if self.found is None or self.found_expected is None or self.found_interval is None:
            return True
        low, high = self.found_interval
        is_near = abs(self.found - self.found_expected) <= FOUND_MARGIN
        return is_near or low <= self.found_expected <= high


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
    means = [float(np.mean(counts)) for counts in ghosts.values()]
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
        float(np.std(means) / np.sqrt(max(len(means) - 1, 1))),
        model.ghosts.rate * (float(inside.mean()) if len(seen) else 0.0),
    )


def _distances(poses: Floats) -> Floats:
    return np.hypot(poses[:, 0], poses[:, 1])
