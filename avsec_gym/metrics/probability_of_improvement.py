"""How probably one player scores higher than another on the same task.

R. Agarwal et al., "Deep reinforcement learning at the edge of the statistical precipice", NeurIPS
2021, section 4.3, with the ties of Mann and Whitney (1947).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.metrics.cluster_bootstrap import Sampled, draw_resamples


def probability_of_improvement(
    trainings: Sequence[Floats], other: Floats, *, resamples: int = 2000, seed: int = 0
) -> Sampled:
    """The probability that a training scores above another player on a task; a tie is half of it.

    The bootstrap draws trainings and tasks, each with replacement: tasks are the same for all
    players, and so are drawn for all together (Owen 2007, "The pigeonhole bootstrap").  Of one
    training only tasks are drawn, of one task only trainings; of both one there is no interval.

    Args:
        trainings: The scores of each training on T tasks, each of shape (T,), T at least 1.
        other: The scores of the other player on the same tasks, shape (T,).
        resamples: Bootstrap samples.
        seed: Seed of the bootstrap.

    Example:
        >>> probability_of_improvement([np.array([0.5, 0.2])], np.array([0.1, 0.2])).value
        0.75
    """
    scores, theirs = np.asarray(trainings, float), np.asarray(other, float)
    wins = (scores > theirs) + 0.5 * (scores == theirs)
    if wins.size < 2:
        return Sampled(float(wins.mean()), np.full(resamples, np.nan))
    runs, tasks = wins.shape
    # Counts, not shares: sums of halves are exact, and no probability is a little above 1.
    drawn_runs = draw_resamples(runs, resamples, seed)
    drawn_tasks = draw_resamples(tasks, resamples, seed + 1)
    return Sampled(float(wins.mean()), ((drawn_runs @ wins) * drawn_tasks).sum(axis=1) / wins.size)
