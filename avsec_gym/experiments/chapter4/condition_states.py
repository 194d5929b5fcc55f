"""All that a run holds of a condition, and the scores of its attack-free regions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.measured_state import MeasuredState
from avsec_gym.experiments.chapter4.settings import (
    ATTACKS,
    BY_GEOMETRY,
    CLEAN,
    CONDITIONS,
    FITTED,
    JUDGED,
    ConnectedCondition,
    DecidedBy,
)
from avsec_gym.experiments.chapter4.state_rows import measured_states
from avsec_gym.geometry import Floats
from avsec_gym.metrics.roc_curve import ClusteredScores, threshold_at
from avsec_gym.runs.results import Results
from avsec_gym.validation.connected.result import AttackKind
from avsec_gym.validation.connected.validator import Method


@dataclass(frozen=True, eq=False)
class ConditionStates:
    """The instants of a condition.

    Args:
        condition: The condition.
        fitted: Attack-free instants that thresholds come from.
        clean: Attack-free instants that are judged, of other places and assets.
        attacked: The same instants under each attack.
    """

    condition: ConnectedCondition
    fitted: Sequence[MeasuredState]
    clean: Sequence[MeasuredState]
    attacked: Mapping[AttackKind, Sequence[MeasuredState]]

    def threshold(self, method: Method, rate: float, by: DecidedBy = BY_GEOMETRY) -> float:
        """The score that a share of the fitted attack-free decidable regions exceeds.

        Args:
            method: The method.
            rate: The designated false positive rate r.
            by: What makes a region decidable.
        """
        return threshold_at(region_scores(self.fitted, method, by).scores, rate)

    def attempts(self, kind: AttackKind) -> list[MeasuredState]:
        """The instants at which there was something to attack."""
        return [state for state in self.attacked[kind] if state.attack is not None]

    def decidable_attacks(
        self, kind: AttackKind, by: DecidedBy = BY_GEOMETRY
    ) -> list[MeasuredState]:
        """The attacks with a decidable region about what was attacked."""
        return [state for state in self.attempts(kind) if state.is_decidable(by)]


def condition_states(results: Results) -> list[ConditionStates]:
    """The conditions of which a run has instants of both parts.

    Args:
        results: The results of a run.
    """
    found = []
    for condition in CONDITIONS:
        fitted = measured_states(results, FITTED, condition, CLEAN)
        clean = measured_states(results, JUDGED, condition, CLEAN)
        if fitted and clean:
            attacked = {kind: measured_states(results, JUDGED, condition, kind) for kind in ATTACKS}
            found.append(ConditionStates(condition, fitted, clean, attacked))
    return found


def region_scores(
    states: Sequence[MeasuredState], method: Method, by: DecidedBy = BY_GEOMETRY
) -> ClusteredScores:
    """Scores of all decidable regions, a cluster for each place."""
    scores = [state.scores[method][state.decidable[by]] for state in states]
    places = [state.place for state, each in zip(states, scores, strict=True) for _ in each]
    return ClusteredScores(np.concatenate([np.zeros(0), *scores]), places)


def attack_scores(
    states: Sequence[MeasuredState], method: Method, by: DecidedBy = BY_GEOMETRY
) -> ClusteredScores:
    """The highest score of each attack, a cluster for each place."""
    scores: Floats = np.array([state.highest(method, by) for state in states], float)
    return ClusteredScores(scores, [state.place for state in states])
