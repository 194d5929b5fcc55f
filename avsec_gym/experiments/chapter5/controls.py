"""Are the attacks sane?  What they do to losses and pixels, with strength, and what noise does."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

import numpy as np

from avsec_gym.experiments.chapter5.decoupling import Sampled, precision, safety
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    NOISES,
    PERTURBATIONS,
    STEPS,
    TEXTURE,
    TEXTURE_ATTACKED,
    UNATTACKED,
    setting,
    specific,
)
from avsec_gym.experiments.chapter5.tables import Row, named
from avsec_gym.metrics.intervals import wilson_interval
from avsec_gym.scenario.intention import Intention

_ROUNDING = 1e-3
"""Grey levels by which float arithmetic may miss a budget."""
_Values = dict[tuple[str, float, str], dict[str, float]]


def control_rows(outcomes: Outcomes) -> list[Row]:
    """The sanity sheet: what attacks do to the loss that they are about, and to pixels.

    A perturbation is to raise the loss against the truth, a patch to lower that towards its ghosts,
    b*; medians over the scenarios.  Controls have the same rows: they should do neither.
    """
    return list(_control_rows(outcomes))


def trend_rows(outcomes: Outcomes) -> list[Row]:
    """What each further step of a perturbation takes: slopes of straight lines over n = 0..4."""
    rows = []
    for detector in dict.fromkeys(one.detector for one in outcomes.conditions):
        for attack in PERTURBATIONS:
            steps = [Condition(detector)]
            steps += [Condition(detector, attack, float(n)) for n in range(1, STEPS + 1)]
            if not set(steps) <= set(outcomes.conditions):
                continue
            row: Row = {"detector": detector, "attack": attack}
            for name, measure in (("precision", precision), ("safety", safety)):
                slope = _slope([measure(outcomes, one) for one in steps])
                row |= {f"{name}_slope": slope.value, f"{name}_slope_interval": slope.interval}
            rows.append(row)
    return rows


def rounding_rows(outcomes: Outcomes) -> list[Row]:
    """What whole grey levels change: each attack in 8 bits against the same in float.

    Attacks whose pixels are whole anyway, such as patches and steps of one level, have no row.
    """
    rows = []
    for rounded in outcomes.conditions:
        exact = Condition(rounded.detector, rounded.attack, rounded.strength)
        if not rounded.whole_levels or exact not in outcomes.conditions:
            continue
        row: Row = named(exact)
        for name, measure in (("precision", precision), ("safety", safety)):
            before, after = measure(outcomes, exact), measure(outcomes, rounded)
            difference = after - before
            row |= {
                f"{name}_float": before.value,
                f"{name}_8_bit": after.value,
                f"{name}_difference": difference.value,
                f"{name}_difference_interval": difference.interval,
            }
        rows.append(row)
    return rows


def _control_rows(outcomes: Outcomes) -> Iterator[Row]:
    values: _Values = defaultdict(dict)
    for row in outcomes.results.measurements():
        values[row["setting"], row["strength"], row["name"]][row["scenario"]] = row["value"]
    for condition in outcomes.conditions:
        if condition.attack == UNATTACKED or condition.whole_levels:
            continue
        filed = _filed(outcomes, condition)
        towards_ghosts = any((name, condition.strength, "ghost_loss") in values for name in filed)
        pairs: list[tuple[float, float]] = []
        changes: list[float] = []
        seen: list[float] = []
        for name in filed:
            key = (name, condition.strength)
            if towards_ghosts:
                before, after = values[*key, "clean_ghost_loss"], values[*key, "ghost_loss"]
            else:
                clean = setting(condition.detector, UNATTACKED)
                before, after = values[clean, 0.0, "loss"], values[*key, "loss"]
            pairs += [
                (before[one], after[one])
                for one in outcomes.scenarios
                if before.get(one) is not None and after.get(one) is not None
            ]
            for found, what in ((changes, "change"), (seen, "ghost_seen")):
                known = values[*key, what]
                found += [known[one] for one in outcomes.scenarios if one in known]
        if pairs or seen:
            yield {
                **named(condition),
                **_losses(condition, pairs, towards_ghosts),
                **_changes(condition, changes),
                **_ghosts_seen(seen),
            }


def _losses(condition: Condition, pairs: list[tuple[float, float]], ghosts: bool) -> Row:
    """What became of the loss, if it was measured."""
    if not pairs:
        unknown = ("loss_towards", "aim", "loss_before", "loss_after", "share_moved")
        return {"cases": 0, **dict.fromkeys((*unknown, "share_moved_interval"))}
    before, after = np.array(pairs).T
    moved = int((after < before).sum() if ghosts else (after > before).sum())
    return {
        "cases": len(pairs),
        "loss_towards": "ghosts" if ghosts else "truth",
        "aim": _aim(condition, ghosts),
        "loss_before": float(np.median(before)),
        "loss_after": float(np.median(after)),
        "share_moved": moved / len(pairs),
        "share_moved_interval": list(wilson_interval(moved, len(pairs))),
    }


def _changes(condition: Condition, changes: list[float]) -> Row:
    budget = _budget(condition)
    return {
        "largest_change": max(changes),
        "budget": budget,
        "within_budget": budget is None or max(changes) <= budget + _ROUNDING,
    }


def _ghosts_seen(seen: list[float]) -> Row:
    """Share of patches whose ghost the planner was given; controls tell what chance gives."""
    if not seen:
        return {"ghosts_seen": None, "ghosts_seen_interval": None}
    count = int(sum(seen))
    return {
        "ghosts_seen": count / len(seen),
        "ghosts_seen_interval": list(wilson_interval(count, len(seen))),
    }


def _aim(condition: Condition, ghosts: bool) -> str | None:
    """Where the attacker wants the loss; None: it is a control, or no attack on a loss."""
    if (
        condition.attack in NOISES
        or condition.attack.startswith("grey")
        or (condition.attack == TEXTURE)
    ):
        return None
    return "down" if ghosts else "up"


def _budget(condition: Condition) -> float | None:
    """Grey levels; None: anything, as in a patch's disc or on a road side of another texture."""
    if condition.attack == TEXTURE_ATTACKED:
        return condition.strength
    if condition.attack in PERTURBATIONS + NOISES:
        return condition.strength * float(condition.attack.partition("-")[2])
    return None


def _filed(outcomes: Outcomes, condition: Condition) -> list[str]:
    """Under what its measurements are: those of a specific attack by intention."""
    if outcomes.looks(condition) == (None,):
        return [condition.setting]
    return [setting(condition.detector, specific(condition.attack, way)) for way in Intention]


def _slope(steps: list[Sampled]) -> Sampled:
    """Per step, by least squares."""
    n = np.arange(len(steps)) - (len(steps) - 1) / 2
    weights: Any = n / (n @ n)
    samples = np.stack([step.samples for step in steps])
    return Sampled(float(weights @ [step.value for step in steps]), weights @ samples)
