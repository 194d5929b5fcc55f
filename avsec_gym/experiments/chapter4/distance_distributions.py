"""Distances of surfaces, attack-free and attacked (figure 4a of the thesis)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.experiments.chapter4.condition_states import ConditionStates
from avsec_gym.experiments.chapter4.measured_state import MeasuredState
from avsec_gym.experiments.chapter4.settings import ATTACKS, CLEAN, State
from avsec_gym.experiments.chapter4.thesis import DISTANCE_BOUND
from avsec_gym.metrics.clustered_shares import Share, share_of

LARGEST = 2.0
"""Metres: the last bin holds what lies beyond, too."""
_BINS = 40


@dataclass(frozen=True)
class DistanceDistribution:
    """Distances of pairs of surfaces under a condition (equation 4.1).

    Args:
        condition: Name of the condition.
        bins: The share of distances, by state, in each of 40 equal bins from 0 to `LARGEST`; the
            last one holds all beyond. Under an attack these are distances of the victim's surface.
        below: The distances, by state, below the thesis' bound, 0.8 m.
        compared: The pairs of surfaces, by state, that have a distance: both vehicles have points
            enough in the region.
    """

    condition: str
    bins: Mapping[str, Sequence[float]]
    below: Mapping[str, Share]
    compared: Mapping[str, Share]


def distance_distribution(states: ConditionStates) -> DistanceDistribution:
    """The distances of a condition.

    Args:
        states: All that a run holds of it.
    """
    by_state: dict[State, Sequence[MeasuredState]] = {CLEAN: states.clean}
    by_state |= {kind: states.attacked[kind] for kind in ATTACKS}
    return DistanceDistribution(
        states.condition.name,
        {state: _histogram(measured) for state, measured in by_state.items()},
        {state: _below(measured) for state, measured in by_state.items()},
        {state: _compared(measured) for state, measured in by_state.items()},
    )


def _histogram(states: Sequence[MeasuredState]) -> list[float]:
    distances = np.concatenate([np.zeros(0), *(state.distances for state in states)])
    shown = np.minimum(distances, np.nextafter(LARGEST, 0))
    counts, _ = np.histogram(shown, np.linspace(0.0, LARGEST, _BINS + 1))
    return (counts / max(len(distances), 1)).tolist()


def _below(states: Sequence[MeasuredState]) -> Share:
    return share_of(
        [distance < DISTANCE_BOUND for state in states for distance in state.distances],
        [state.place for state in states for _ in state.distances],
    )


def _compared(states: Sequence[MeasuredState]) -> Share:
    return share_of(
        [pair < len(state.distances) for state in states for pair in range(state.pairs)],
        [state.place for state in states for _ in range(state.pairs)],
    )
