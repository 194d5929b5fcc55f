"""The results of a run of chapter 4."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from avsec_gym.experiments.chapter4.attack_rates import AttackRates, attack_rates
from avsec_gym.experiments.chapter4.condition_states import condition_states
from avsec_gym.experiments.chapter4.detection_rates import DetectionRate, detection_rates
from avsec_gym.experiments.chapter4.distance_distributions import (
    DistanceDistribution,
    distance_distribution,
)
from avsec_gym.experiments.chapter4.distance_rates import DistanceRate, distance_rates
from avsec_gym.experiments.chapter4.false_alarms import InstantFalseAlarms, false_alarms
from avsec_gym.experiments.chapter4.instant_times import InstantTime, instant_times
from avsec_gym.experiments.chapter4.naming_rates import (
    HonestNamed,
    NamingRate,
    honest_named,
    naming_rates,
)
from avsec_gym.experiments.chapter4.reliability import ReliabilityBin, reliability
from avsec_gym.experiments.chapter4.removed_categories import RemovedCategory, removed_categories
from avsec_gym.experiments.chapter4.roc_rates import RocRow, roc_rows
from avsec_gym.experiments.chapter4.sent_bytes import (
    KindBytes,
    SentBytes,
    bytes_of_kinds,
    sent_bytes,
)
from avsec_gym.experiments.chapter4.settings import FITTED, JUDGED
from avsec_gym.experiments.chapter4.step_times import StepTime, step_times
from avsec_gym.runs.run_folder import RunFolder


@dataclass(frozen=True)
class ConnectedSummary:
    """All figures of a run on connected vehicles.

    Args:
        instants: The number of instants of each part, by condition.
        distances: Distances of surfaces.
        detection: Detection over r.
        roc: ROC curves.
        attacks: What becomes of all attacks.
        namings: Who is named at attacks.
        honest: How often an honest vehicle is named.
        by_distance: Detection over the distance from the victim.
        removed: What was removed.
        reliability: How far probabilities can be trusted.
        false_alarms: False alarms for each region and frame.
        sent: The bytes that vehicles send.
        sent_kinds: The bytes of each kind of message, of vehicles and of the base station.
        times: Computing time of each step.
        after_proposals: Computing time of all steps after the proposals.
    """

    instants: Mapping[str, Mapping[str, int]]
    distances: Sequence[DistanceDistribution]
    detection: Sequence[DetectionRate]
    roc: Sequence[RocRow]
    attacks: Sequence[AttackRates]
    namings: Sequence[NamingRate]
    honest: Sequence[HonestNamed]
    by_distance: Sequence[DistanceRate]
    removed: Sequence[RemovedCategory]
    reliability: Sequence[ReliabilityBin]
    false_alarms: Sequence[InstantFalseAlarms]
    sent: Sequence[SentBytes]
    sent_kinds: Sequence[KindBytes]
    times: Sequence[StepTime]
    after_proposals: Sequence[InstantTime]


def connected_summary(run: RunFolder) -> ConnectedSummary | None:
    """All figures of a run; None as long as no condition has instants of both parts.

    Args:
        run: The run.
    """
    conditions = condition_states(run)
    if not conditions:
        return None
    return ConnectedSummary(
        instants={
            states.condition.name: {FITTED: len(states.fitted), JUDGED: len(states.clean)}
            for states in conditions
        },
        distances=[distance_distribution(states) for states in conditions],
        detection=[row for states in conditions for row in detection_rates(states)],
        roc=[row for states in conditions for row in roc_rows(states)],
        attacks=[row for states in conditions for row in attack_rates(states)],
        namings=[row for states in conditions for row in naming_rates(states)],
        honest=[row for states in conditions for row in honest_named(states)],
        by_distance=[row for states in conditions for row in distance_rates(states)],
        removed=[row for states in conditions for row in removed_categories(states)],
        reliability=[row for states in conditions for row in reliability(states)],
        false_alarms=[row for states in conditions for row in false_alarms(states)],
        sent=[row for states in conditions for row in sent_bytes(states)],
        sent_kinds=[row for states in conditions for row in bytes_of_kinds(states)],
        after_proposals=[row for states in conditions for row in instant_times(states)],
        times=step_times(run.timings()),
    )
