"""What a patch's ghost does to an episode: where the ghost is seen, and where it is not."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter5.outcomes import RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    GREY_PATCHES,
    JOINT_PATCHES,
    PATCHES,
    setting,
    specific,
)
from avsec_gym.experiments.json_rows import keyed
from avsec_gym.metrics.cluster_bootstrap import mean_over_clusters
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.scenario.intention import Intention


@dataclass(frozen=True)
class PatchEffectRow:
    """How often a patch's ghost is seen, and how often the episode becomes unsafe then.

    Args:
        condition: The detector under the patch.
        episodes: Number of episodes that are safe unattacked; no others count.  ``drives`` in
            files, whose format it is.
        seen: Share of those whose ghost is seen.
        unsafe_seen: Share of those with a ghost seen that become unsafe.
        unsafe_unseen: Share of the others that become unsafe: what else a patch does, such as
            hiding what is behind it.
    """

    condition: Condition
    episodes: int = field(metadata=keyed("drives"))
    seen: Estimate
    unsafe_seen: Estimate
    unsafe_unseen: Estimate


def patch_effect_rows(outcomes: Outcomes) -> list[PatchEffectRow]:
    """How often a patch's ghost is seen, and how often the episode becomes unsafe then.

    Args:
        outcomes: The outcomes of a run.

    Returns:
        A row for each condition with a patch whose detector was run unattacked, too.  Episodes of
        one scenario share its scene, and a random patch, so that intervals are by bootstrap over
        scenarios; where no episode counts or all do, which resamples cannot doubt, they are
        those of `share_of`, of about as many cases as there are scenarios.
    """
    patched = PATCHES + JOINT_PATCHES + GREY_PATCHES
    rows = (
        _row(outcomes, condition)
        for condition in outcomes.conditions
        if condition.attack in patched and condition.unattacked in outcomes.conditions
    )
    return [row for row in rows if row is not None]


def _row(outcomes: Outcomes, condition: Condition) -> PatchEffectRow | None:
    episodes: list[tuple[str, bool, bool]] = []
    for intention in Intention:
        ghosts = _ghosts_seen(outcomes, condition, intention)
        pairs = zip(
            outcomes.records(condition.unattacked, intention),
            outcomes.records(condition, intention),
            strict=True,
        )
        for before, after in pairs:
            if before.safe and after.scenario in ghosts:
                episodes.append((after.scenario, ghosts[after.scenario], not after.safe))
    if not episodes:
        return None
    names, ghost_flags, unsafe_flags = zip(*episodes, strict=True)
    scenarios, seen, unsafe = np.array(names), np.array(ghost_flags), np.array(unsafe_flags)
    return PatchEffectRow(
        condition,
        len(episodes),
        seen=_share(seen, scenarios),
        unsafe_seen=_share(unsafe[seen], scenarios[seen]),
        unsafe_unseen=_share(unsafe[~seen], scenarios[~seen]),
    )


def _ghosts_seen(outcomes: Outcomes, condition: Condition, intention: Intention) -> dict[str, bool]:
    apart = outcomes.looks(condition) != (None,)
    attack = specific(condition.attack, intention) if apart else condition.attack
    rows = outcomes.results.measurements(
        name="ghost_seen", setting=setting(condition.detector, attack)
    )
    return {row.scenario: row.value > 0 for row in rows}


def _share(flags: NDArray[np.bool_], scenarios: NDArray[np.str_]) -> Estimate:
    """The share of episodes whose flag is set.

    Args:
        flags: A flag of each episode, shape (N,).
        scenarios: The scenario of each.
    """
    if not len(flags):
        return NOTHING
    if 0 < flags.mean() < 1:
        return mean_over_clusters(flags, scenarios.tolist(), resamples=RESAMPLES).estimate
    return share_of(flags, scenarios.tolist()).estimate
