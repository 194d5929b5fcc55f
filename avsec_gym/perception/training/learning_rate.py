"""The learning rate of every step: up along half a cosine, and down along another."""

from __future__ import annotations

import math

from avsec_gym.perception.training.configuration import TrainingConfiguration

_FIRST_RATE = 0.04


def learning_rate(step: int, steps: int, configuration: TrainingConfiguration) -> float:
    """The rate of a step; a pure function, so that a resumed run needs no scheduler's state.

    Args:
        step: The step, from 0 to ``steps - 1``.
        steps: The number of steps of the whole training.
        configuration: Highest and last rate, and the share of steps that rise.

    Source:
        One-cycle schedule: Smith and Topin, Super-convergence, 2018; without its momentum cycle.

    Example:
        >>> half = TrainingConfiguration(learning_rate=1.0, warm_up=0.5, final_rate=0.0)
        >>> [round(learning_rate(step, 8, half), 2) for step in range(8)]
        [0.04, 0.18, 0.52, 0.86, 1.0, 0.85, 0.5, 0.15]
    """
    highest = configuration.learning_rate
    rising = configuration.warm_up * steps
    if step < rising:
        return highest * _between(_FIRST_RATE, 1.0, step / rising)
    falling = (step - rising) / max(steps - rising, 1.0)
    return highest * _between(1.0, configuration.final_rate, falling)


def _between(start: float, end: float, progress: float) -> float:
    return end + (start - end) * 0.5 * (1 + math.cos(math.pi * progress))
