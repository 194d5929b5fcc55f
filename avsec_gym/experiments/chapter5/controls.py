"""Are the attacks sane?  What they do to losses and pixels, with strength, and what noise does."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.experiments.chapter5.losses import precision, safety
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
from avsec_gym.geometry import Floats
from avsec_gym.metrics.cluster_bootstrap import Sampled
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.scenario.intention import Intention

_ROUNDING = 1e-3
"""Grey levels by which float arithmetic may miss a budget."""
_Values = dict[tuple[str, float, str], dict[str, float]]
"""Values by setting, strength and name of a measurement: its value in each scenario."""


@dataclass(frozen=True)
class ControlRow:
    """What an attack does to its loss and to pixels.

    Args:
        condition: The detector under the attack.
        cases: Number of scenarios whose loss was measured.
        loss_towards: ``truth`` or ``ghosts``, what the loss is to; None: it was not measured.
        aim: ``up`` or ``down``, where the attacker wants the loss; None: a control.
        loss_before: Median of the clean losses.
        loss_after: Median of the attacked losses.
        share_moved: Share of the scenarios whose loss moved as an attacker wants it.
        largest_change: Largest change of a grey level.
        budget: Largest change that the attack may make; None: any.
        within_budget: Whether it kept to it.
        ghosts_seen: Share of patches whose ghost the planner was given.
    """

    condition: Condition
    cases: int
    loss_towards: str | None
    aim: str | None
    loss_before: float | None
    loss_after: float | None
    share_moved: Estimate
    largest_change: float
    budget: float | None
    within_budget: bool
    ghosts_seen: Estimate


@dataclass(frozen=True)
class TrendRow:
    """What each further step of a perturbation changes, percentage points.

    Args:
        detector: The detector.
        attack: The perturbation.
        precision_slope: Change of average precision with each step.
        safety_slope: Change of the safe driving rate with each step.
    """

    detector: str
    attack: str
    precision_slope: Estimate
    safety_slope: Estimate


@dataclass(frozen=True)
class RoundingRow:
    """An attack in float and in whole grey levels, percent.

    Args:
        condition: The detector under the attack, in float.
        precision_float: Average precision in float.
        precision_8_bit: Average precision in whole levels.
        precision_difference: The second less the first.
        safety_float: Safe driving rate in float.
        safety_8_bit: Safe driving rate in whole levels.
        safety_difference: The second less the first.
    """

    condition: Condition
    precision_float: float
    precision_8_bit: float
    precision_difference: Estimate
    safety_float: float
    safety_8_bit: float
    safety_difference: Estimate


def control_rows(outcomes: Outcomes) -> list[ControlRow]:
    """The sanity sheet: what attacks do to the loss that they are about, and to pixels.

    A perturbation is to raise the loss against the truth, a patch to lower that towards its ghosts,
    b*; medians over the scenarios.  Controls have the same rows: they should do neither.
    """
    values: _Values = defaultdict(dict)
    for row in outcomes.results.measurements():
        values[row.setting, row.strength, row.name][row.scenario] = row.value
    rows = (
        _control_row(outcomes, condition, values)
        for condition in outcomes.conditions
        if condition.attack != UNATTACKED and not condition.whole_levels
    )
    return [row for row in rows if row is not None]


def trend_rows(outcomes: Outcomes) -> list[TrendRow]:
    """What each further step of a perturbation takes: slopes of straight lines over n = 0..4."""
    rows = []
    for detector in dict.fromkeys(condition.detector for condition in outcomes.conditions):
        for attack in PERTURBATIONS:
            steps = [Condition(detector)]
            steps += [Condition(detector, attack, float(n)) for n in range(1, STEPS + 1)]
            if set(steps) <= set(outcomes.conditions):
                slopes = (
                    _slope([measure(outcomes, step) for step in steps]).estimate
                    for measure in (precision, safety)
                )
                rows.append(TrendRow(detector, attack, *slopes))
    return rows


def rounding_rows(outcomes: Outcomes) -> list[RoundingRow]:
    """What whole grey levels change: each attack in 8 bits against the same in float.

    Attacks whose pixels are whole anyway, such as patches and steps of one level, have no row.
    """
    rows = []
    for rounded in outcomes.conditions:
        exact = Condition(rounded.detector, rounded.attack, rounded.strength)
        if not rounded.whole_levels or exact not in outcomes.conditions:
            continue
        before, after = precision(outcomes, exact), precision(outcomes, rounded)
        safe_before, safe_after = safety(outcomes, exact), safety(outcomes, rounded)
        rows.append(
            RoundingRow(
                exact,
                precision_float=before.value,
                precision_8_bit=after.value,
                precision_difference=(after - before).estimate,
                safety_float=safe_before.value,
                safety_8_bit=safe_after.value,
                safety_difference=(safe_after - safe_before).estimate,
            )
        )
    return rows


def _control_row(outcomes: Outcomes, condition: Condition, values: _Values) -> ControlRow | None:
    """Of one condition; None where nothing was measured."""
    filed = _filed(outcomes, condition)
    towards_ghosts = any((name, condition.strength, "ghost_loss") in values for name in filed)
    pairs: list[tuple[str, float, float]] = []
    changes: list[float] = []
    seen: list[tuple[str, float]] = []
    for name in filed:
        key = (name, condition.strength)
        # 1. The loss that the attack is about, before and after, where both were measured.
        if towards_ghosts:
            before, after = values[*key, "clean_ghost_loss"], values[*key, "ghost_loss"]
        else:
            clean = setting(condition.detector, UNATTACKED)
            before, after = values[clean, 0.0, "loss"], values[*key, "loss"]
        pairs += [
            (scenario, before[scenario], after[scenario])
            for scenario in outcomes.scenarios
            if _is_measured(before, scenario) and _is_measured(after, scenario)
        ]
        # 2. The largest change of a pixel, and whether a patch's ghost was seen.
        largest, ghosts = values[*key, "change"], values[*key, "ghost_seen"]
        changes += [largest[scenario] for scenario in outcomes.scenarios if scenario in largest]
        seen += [(each, ghosts[each]) for each in outcomes.scenarios if each in ghosts]
    if not pairs and not seen:
        return None
    # 3. Whether the loss moved the way that it should, and the change kept to its budget.
    losses = np.array([pair[1:] for pair in pairs], float).reshape(-1, 2)
    moved = losses[:, 1] < losses[:, 0] if towards_ghosts else losses[:, 1] > losses[:, 0]
    budget = _budget(condition)
    return ControlRow(
        condition,
        cases=len(pairs),
        loss_towards=("ghosts" if towards_ghosts else "truth") if pairs else None,
        aim=_aim(condition, towards_ghosts) if pairs else None,
        loss_before=_median(losses[:, 0]),
        loss_after=_median(losses[:, 1]),
        share_moved=_share(moved, [pair[0] for pair in pairs]),
        largest_change=max(changes),
        budget=budget,
        within_budget=budget is None or max(changes) <= budget + _ROUNDING,
        ghosts_seen=_share([value for _, value in seen], [scenario for scenario, _ in seen]),
    )


def _is_measured(values: Mapping[str, float], scenario: str) -> bool:
    return not math.isnan(values.get(scenario, math.nan))


def _median(values: Floats) -> float | None:
    return float(np.median(values)) if len(values) else None


def _share(flags: ArrayLike, scenarios: Sequence[str]) -> Estimate:
    """The share of ones; looks at one scenario, such as for each intention, are a cluster."""
    return share_of(flags, scenarios).estimate


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
    """The settings of its measurements: a specific attack has one for each intention."""
    if outcomes.looks(condition) == (None,):
        return [condition.setting]
    return [setting(condition.detector, specific(condition.attack, way)) for way in Intention]


def _slope(steps: list[Sampled]) -> Sampled:
    """Per step, by least squares."""
    n = np.arange(len(steps)) - (len(steps) - 1) / 2
    weights = n / (n @ n)
    values, samples = [step.value for step in steps], np.stack([step.samples for step in steps])
    return Sampled(float(weights @ values), weights @ samples)
