"""How often adaptive attacks are detected and identified, and how often a sound sensor is named."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter3.identification.adaptive_attacks import KINDS, states_of
from avsec_gym.experiments.chapter3.identification.beyond_rates import RATE
from avsec_gym.experiments.chapter3.identification.detection_rates import exceeded
from avsec_gym.experiments.chapter3.identification.evidence_table import (
    EvidenceTable,
    evidence_table,
)
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    algorithm_2,
    maximum_likelihood,
)
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import bits
from avsec_gym.experiments.chapter3.recordings import SYSTEM
from avsec_gym.experiments.chapter3.settings import SCENARIOS
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.runs.results import Results
from avsec_gym.validation.fitted_on import FittedOn
from avsec_gym.validation.likelihood.maximum_likelihood import LikelihoodModel


@dataclass(frozen=True)
class AdaptiveAttackRates:
    """How often an adaptive attack is detected, and its sensors named.

    Args:
        kind: The kind of attack, one of `KINDS`.
        attacked: Positions of the attacked sensors.
        detected: The share that is detected by each of the `SCENARIOS` that holds one of them.
        named: The share named by algorithm 2, exactly these.
        named_likeliest: The share named by maximum likelihood, exactly these.
        accused: Maximum likelihood names a sound sensor.
    """

    kind: str
    attacked: Sequence[int]
    detected: Mapping[str, Share]
    named: Share
    named_likeliest: Share
    accused: Share


def adaptive_rates(
    results: Results, fitted: EvidenceTable, on: FittedOn, model: LikelihoodModel
) -> list[AdaptiveAttackRates]:
    """The rates at r = 1 % for each kind and set of attacked sensors.

    Args:
        results: The results of a run; without `adaptive_attacks` there are no rows.
        fitted: The frames whose clean states give the thresholds.
        on: The sensors and the depth that they hold for.
        model: The likelihood model that was fitted on the same frames.
    """
    rows = []
    for name, kind in KINDS.items():
        states = states_of(kind, len(SYSTEM))
        if not results.measurements(setting=f"{name} {bits(states[0])}"):
            continue
        table = evidence_table(results, name, SYSTEM, states)
        alarms = exceeded(fitted, table, on, RATE)
        by_algorithm = algorithm_2(fitted, table, on, RATE).sensors
        likeliest = maximum_likelihood(model, table, RATE).sensors
        for number, (attacked, state) in enumerate(zip(kind.attacked, states, strict=True)):
            detected = {
                scenario: share_of(alarms[:, number, SYSTEM.triples.index(triple)], table.drives)
                for scenario, triple in SCENARIOS.items()
                if {*attacked} & {*triple}
            }
            hits = {
                "named": (by_algorithm[:, number] == state).all(axis=1),
                "named_likeliest": (likeliest[:, number] == state).all(axis=1),
                "accused": (likeliest[:, number] & ~state).any(axis=1),
            }
            shares = {what: share_of(np.asarray(hit), table.drives) for what, hit in hits.items()}
            rows.append(AdaptiveAttackRates(name, list(attacked), detected, **shares))
    return rows
