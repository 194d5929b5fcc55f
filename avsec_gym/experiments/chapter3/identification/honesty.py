"""What the likelihood's answers are worth: to whom it says what, and with which probability."""

from __future__ import annotations

from typing import Any

import numpy as np

from avsec_gym.experiments.chapter3.identification.evidence_table import EvidenceTable
from avsec_gym.experiments.chapter3.shares import share_of
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel
from avsec_gym.validation.state_posterior import (
    Verdict,
    attack_prior,
    brier_score,
    reliability,
    state_vectors,
)

_DRAWS = 64
"""Of each moment, whose states are drawn as often as the prior expects them."""


def honesty(model: LikelihoodModel, judged: EvidenceTable) -> dict[str, Any]:
    """What users of `LikelihoodValidator` are told, by the rule, rate and prior that it comes with.

    Args:
        model: That was fitted on other moments.
        judged: In all states.

    Returns:
        ``rate``, ``certainty``; ``verdicts``: for each number of attacked sensors, by its text, the
        shares of the verdicts on all sensors that are ``right``, ``wrong`` and ``cannot_tell``,
        and of the moments in which ``all_right`` are, and with ``alarms``; ``brier`` and
        ``reliability`` (rows of `reliability`, None where nothing was said) of the probabilities,
        over states drawn from the prior.
    """
    states, drives = state_vectors(model.sensors), judged.drives
    moments = len(judged)
    rate, certainty = LikelihoodValidator.rate, LikelihoodValidator.certainty
    decoding = model.decode(judged.shares.reshape(moments * len(states), -1), rate)
    said = np.array(decoding.verdicts(certainty)).reshape(moments, len(states), -1)
    alarms = decoding.alarms.reshape(moments, len(states))
    unknown = said == Verdict.CANNOT_TELL
    right = said == np.where(states, Verdict.ATTACKED, Verdict.SOUND)
    verdicts = {}
    for count in range(model.sensors + 1):
        chosen = np.flatnonzero(states.sum(axis=1) == count)
        verdicts[str(count)] = {
            "right": share_of(right[:, chosen], drives),
            "wrong": share_of(~(right | unknown)[:, chosen], drives),
            "cannot_tell": share_of(unknown[:, chosen], drives),
            "all_right": share_of(right[:, chosen].all(axis=2), drives),
            "alarms": share_of(alarms[:, chosen], drives),
        }
    prior = attack_prior(model.sensors)
    drawn = np.random.default_rng(0).choice(len(states), (_DRAWS, moments), p=prior)
    posterior = model.posterior(judged.shares[np.arange(moments), drawn].reshape(drawn.size, -1))
    truth = states[drawn.ravel()]
    return {
        "rate": rate,
        "certainty": certainty,
        "verdicts": verdicts,
        "brier": brier_score(posterior, truth),
        "reliability": [
            None if np.isnan(row).any() else row.tolist() for row in reliability(posterior, truth)
        ],
    }
