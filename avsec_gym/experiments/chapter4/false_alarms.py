"""False alarms for each region and for each frame, thresholds held out."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.experiments.chapter4.condition_states import ConditionStates, region_scores
from avsec_gym.experiments.chapter4.settings import BY_GEOMETRY, METHODS, RATES
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.validation.connected.validator import Method


@dataclass(frozen=True)
class InstantFalseAlarms:
    """How often attack-free instants alarm.

    Args:
        condition: Name of the condition.
        method: The method.
        rate: The designated false positive rate r of regions.
        regions: The decidable attack-free regions that alarm.
        frames: The attack-free instants at which a region alarms.
        each_frame: Mean number of alarms at an instant.
        decidable: The attack-free regions that are decidable.
    """

    condition: str
    method: Method
    rate: float
    regions: Share
    frames: Share
    each_frame: float
    decidable: Share


def false_alarms(states: ConditionStates) -> list[InstantFalseAlarms]:
    """The false alarms of a condition.

    Args:
        states: All that a run holds of it.
    """
    return [_alarms(states, method, rate) for method in METHODS for rate in RATES]


def _alarms(states: ConditionStates, method: Method, rate: float) -> InstantFalseAlarms:
    threshold, clean = states.threshold(method, rate), states.clean
    regions = region_scores(clean, method)
    alarms = regions.scores > threshold
    return InstantFalseAlarms(
        states.condition.name,
        method,
        rate,
        regions=share_of(alarms, regions.clusters),
        frames=share_of(
            [state.highest(method) > threshold for state in clean],
            [state.place for state in clean],
        ),
        each_frame=float(alarms.sum()) / len(clean),
        decidable=share_of(
            [decidable for state in clean for decidable in state.decidable[BY_GEOMETRY]],
            [state.place for state in clean for _ in range(state.regions)],
        ),
    )
