"""Scores as probabilities: 0.3 means that three in ten such boxes are real.

Networks that were trained briefly give scores of little more than 0.3, others 0.9; a threshold on
scores means the same for all of them only once they are calibrated.  Where a detector knows more of
a box than how surely it is a car, such as how well both images agree on its place, that counts too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, log_expit, logit

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.perception.weights.model_card import ModelCard

NAME = "score_calibration"
"""The key of the calibration in what a card of weights has `beside`."""
_EDGE = 1e-6


@dataclass(frozen=True)
class ScoreCalibration:
    """Log-odds as a linear function; the default leaves scores as they are.

    Args:
        slope: The slope of the score's own log-odds, positive.
        offset: The number that is added.
        evidence: Weights of whatever else the detector knows of a box; none: the order of scores
            stays as it was.

    Source:
        Platt, Probabilistic outputs for support vector machines, 1999.
    """

    slope: float = 1.0
    offset: float = 0.0
    evidence: tuple[float, ...] = ()

    @classmethod
    def of_card(cls, card: ModelCard | None) -> ScoreCalibration:
        """The calibration of a card of weights; scores stay as they are where the card has none."""
        slope, offset, *evidence = (card.beside.get(NAME) if card else None) or (1.0, 0.0)
        return cls(slope, offset, tuple(evidence))

    def __call__(self, scores: Floats, evidence: Floats | None = None) -> Floats:
        """Probabilities of boxes.

        Args:
            scores: The scores, in [0, 1], shape (N,).
            evidence: What else is known of them, shape (N, K); not looked at if it has no weights.
        """
        if self == ScoreCalibration():
            return scores
        odds = self.slope * logit(np.clip(scores, _EDGE, 1 - _EDGE)) + self.offset
        if self.evidence and evidence is not None:
            odds = odds + evidence @ np.array(self.evidence)
        return np.asarray(expit(odds))


def fit_score_calibration(
    scores: Floats, right: Floats, wrong: Floats, evidence: Floats | None = None
) -> ScoreCalibration:
    """The function under which what was found is likeliest.

    One box more of either kind, at the mean of all, keeps a few boxes from making it certain.

    Args:
        scores: The scores, in [0, 1], shape (E,).
        right: How many boxes of each score are real, shape (E,).
        wrong: How many are not, shape (E,).
        evidence: What else is known of them, shape (E, K); none if None.

    Raises:
        DataError: No box is right, or none is wrong, or higher scores are right less often.
    """
    if not (right.any() and wrong.any()):
        raise DataError(
            f"Of the boxes, {right.sum():g} are right and {wrong.sum():g} wrong.",
            remedy="Calibrate on more frames, or train the network longer.",
        )
    odds = logit(np.clip(scores, _EDGE, 1 - _EDGE))
    known = np.column_stack([odds] if evidence is None else [odds, evidence])
    x = np.vstack([known, np.average(known, axis=0, weights=right + wrong)])
    hits, misses = np.append(right, 1.0), np.append(wrong, 1.0)

    def surprise(parameters: Floats) -> float:
        z = parameters[0] + x @ parameters[1:]
        return float(-(hits * log_expit(z) + misses * log_expit(-z)).sum())

    start = np.zeros(1 + x.shape[1])
    start[1] = 1.0
    offset, slope, *others = map(float, minimize(surprise, start, method="BFGS").x)
    if slope <= 0:
        raise DataError(
            "Boxes with higher scores are right less often.",
            remedy="Calibrate on more frames, or train the network longer.",
        )
    return ScoreCalibration(slope, offset, tuple(others))
