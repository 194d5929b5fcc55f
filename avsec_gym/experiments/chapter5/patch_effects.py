"""What a patch's ghost does to the drive: of drives whose ghost is seen, and of those others."""

from __future__ import annotations

from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    GREY_PATCHES,
    JOINT_PATCHES,
    PATCHES,
    setting,
    specific,
)
from avsec_gym.experiments.chapter5.tables import Row, named
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
        A row for each condition with a patch, each share with its 95 % Wilson interval; None where
        there is nothing to share.
    """
    patched = PATCHES + JOINT_PATCHES + GREY_PATCHES
    conditions = [one for one in outcomes.conditions if one.attack in patched]
    return [row for one in conditions if (row := _row(outcomes, one)) is not None]


def _row(outcomes: Outcomes, condition: Condition) -> Row | None:
    seen: list[bool] = []
    unsafe: list[bool] = []
    for intention in Intention:
        ghosts = _ghosts_seen(outcomes, condition, intention)
        pairs = zip(
            outcomes.records(condition.unattacked, intention),
            outcomes.records(condition, intention),
            strict=True,
        )
        for before, after in pairs:
            if before.safe and after.scenario in ghosts:
                seen.append(ghosts[after.scenario])
                unsafe.append(not after.safe)
    if not seen:
        return None
    both = list(zip(seen, unsafe, strict=True))
    return {
        **named(condition),
        "drives": len(both),
        **_share("seen", seen),
        **_share("unsafe_seen", [lost for ghost, lost in both if ghost]),
        **_share("unsafe_unseen", [lost for ghost, lost in both if not ghost]),
    }


def _ghosts_seen(outcomes: Outcomes, condition: Condition, intention: Intention) -> dict[str, bool]:
    apart = outcomes.looks(condition) != (None,)
    attack = specific(condition.attack, intention) if apart else condition.attack
    rows = outcomes.results.measurements(
        name="ghost_seen", setting=setting(condition.detector, attack)
    )
    return {row["scenario"]: row["value"] > 0 for row in rows}


def _share(name: str, flags: list[bool]) -> Row:
    if not flags:
        return {name: None, f"{name}_interval": None}
    count = sum(flags)
    return {
        name: count / len(flags),
        f"{name}_interval": list(wilson_interval(count, len(flags))),
    }
