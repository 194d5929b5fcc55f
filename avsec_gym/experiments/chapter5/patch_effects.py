"""What a patch's ghost does to the drive: of drives whose ghost is seen, and of those others."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter5.decoupling import Sampled
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    GREY_PATCHES,
    JOINT_PATCHES,
    PATCHES,
    setting,
    specific,
)
from avsec_gym.experiments.chapter5.tables import Row, named
from avsec_gym.metrics.average_precision_curves import draw_resamples
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.scenario.intention import Intention


def patch_effect_rows(outcomes: Outcomes) -> list[Row]:
    """How often a patch's ghost is seen, and how often the drive becomes unsafe then.

    Only drives count that are safe unattacked.  ``unsafe_seen`` are those that are unsafe with the
    patch where its ghost is seen (see `attacked_drives`), ``unsafe_unseen`` where it is not: what
    else a patch does, such as hiding what is behind it.

    Args:
        outcomes: Of a run.

    Returns:
        A row for each condition with a patch whose detector drove unattacked, too; each share with
        its 95 % interval, None where there is nothing to share.  Drives of one scenario share its
        scene, and a random patch, so that intervals are by bootstrap over scenarios; where no drive
        counts or all do, which resamples cannot doubt, they are Wilson's, of as many cases as there
        are scenarios.
    """
    patched = PATCHES + JOINT_PATCHES + GREY_PATCHES
    there = outcomes.conditions
    conditions = [one for one in there if one.attack in patched and one.unattacked in there]
    return [row for one in conditions if (row := _row(outcomes, one)) is not None]


def _row(outcomes: Outcomes, condition: Condition) -> Row | None:
    drives: list[tuple[str, bool, bool]] = []
    for intention in Intention:
        ghosts = _ghosts_seen(outcomes, condition, intention)
        pairs = zip(
            outcomes.records(condition.unattacked, intention),
            outcomes.records(condition, intention),
            strict=True,
        )
        for before, after in pairs:
            if before.safe and after.scenario in ghosts:
                drives.append((after.scenario, ghosts[after.scenario], not after.safe))
    if not drives:
        return None
    names, ghost_flags, unsafe_flags = zip(*drives, strict=True)
    scenarios, seen, unsafe = np.array(names), np.array(ghost_flags), np.array(unsafe_flags)
    return {
        **named(condition),
        "drives": len(drives),
        **_share("seen", seen, scenarios),
        **_share("unsafe_seen", unsafe[seen], scenarios[seen]),
        **_share("unsafe_unseen", unsafe[~seen], scenarios[~seen]),
    }


def _ghosts_seen(outcomes: Outcomes, condition: Condition, intention: Intention) -> dict[str, bool]:
    apart = outcomes.looks(condition) != (None,)
    attack = specific(condition.attack, intention) if apart else condition.attack
    rows = outcomes.results.measurements(
        name="ghost_seen", setting=setting(condition.detector, attack)
    )
    return {row["scenario"]: row["value"] > 0 for row in rows}


def _share(name: str, flags: NDArray[np.bool_], scenarios: NDArray[np.str_]) -> Row:
    """Of drives, shape (N,), and the scenario of each."""
    if not len(flags):
        return {name: None, f"{name}_interval": None}
    _, row = np.unique(scenarios, return_inverse=True)
    hits, cases = np.bincount(row, flags), np.bincount(row)
    share = float(flags.mean())
    interval: list[float] | None
    if 0 < share < 1:
        samples = draw_resamples(len(cases), RESAMPLES, 0)
        interval = Sampled(share, (samples @ hits) / (samples @ cases)).interval
    else:
        interval = list(wilson_interval(int(share) * len(cases), len(cases)))
    return {name: share, f"{name}_interval": interval}
