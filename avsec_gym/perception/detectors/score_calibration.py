"""Scores as probabilities: 0.3 means that three in ten such boxes are real.

Networks that were trained briefly say little more than 0.3 of anything, others 0.9; a threshold on
scores means the same for all of them only once they are calibrated.  No order changes, so neither
does average precision.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, log_expit, logit

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.perception.weights.store import ModelCard

NAME = "score_calibration"
"""Among what the card of weights has `beside`."""
_EDGE = 1e-6


@dataclass(frozen=True)
class ScoreCalibration:
    """A straight line between log-odds; the default leaves scores as they are.

    Args:
        slope: Positive.
        offset: Added.

    Source:
        Platt, Probabilistic outputs for support vector machines, 1999.
    """

    slope: float = 1.0
    offset: float = 0.0

    @classmethod
    def of_card(cls, card: ModelCard | None) -> ScoreCalibration:
        """That of weights; scores stay as they are where their card has none."""
        return cls(*(card.beside.get(NAME, ()) if card else ()))

    def __call__(self, scores: Floats) -> Floats:
        """Probabilities of scores in [0, 1]."""
        if self == ScoreCalibration():
            return scores
        clipped = np.clip(scores, _EDGE, 1 - _EDGE)
        return np.asarray(expit(self.slope * logit(clipped) + self.offset))


def fit_score_calibration(scores: Floats, right: Floats, wrong: Floats) -> ScoreCalibration:
    """The line under which what was found is likeliest.

    One box more of either kind, at the mean log-odds, keeps a few boxes from making it certain.

    Args:
        scores: In [0, 1], shape (E,).
        right: How many boxes of each score are real, shape (E,).
        wrong: How many are not, shape (E,).

    Raises:
        DataError: No box is right, or none is wrong, or higher scores are right less often.
    """
    if not (right.any() and wrong.any()):
        raise DataError(
            f"Of the boxes, {right.sum():g} are right and {wrong.sum():g} wrong.",
            remedy="Calibrate on more frames, or train the network longer.",
        )
    odds = logit(np.clip(scores, _EDGE, 1 - _EDGE))
    mean = float(np.average(odds, weights=right + wrong))
    x = np.append(odds, mean)
    hits, misses = np.append(right, 1.0), np.append(wrong, 1.0)

    def surprise(line: Floats) -> float:
        z = line[0] * x + line[1]
        return float(-(hits * log_expit(z) + misses * log_expit(-z)).sum())

    slope, offset = minimize(surprise, [1.0, 0.0], method="BFGS").x
    if slope <= 0:
        raise DataError(
            "Boxes with higher scores are right less often.",
            remedy="Calibrate on more frames, or train the network longer.",
        )
    return ScoreCalibration(float(slope), float(offset))
