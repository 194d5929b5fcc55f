"""Two inputs on the same scenarios: differences of the rates with paired intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from avsec_gym.metrics.intervals import mcnemar_p
from avsec_gym.metrics.many_comparisons import holm_adjusted
from avsec_gym.metrics.safety import COLLISION, SAFE, UNPLANNED, SafetyRecord


def paired_differences(
    first: Sequence[SafetyRecord],
    second: Sequence[SafetyRecord],
    *,
    resamples: int = 10_000,
    seed: int = 0,
) -> dict[str, Any]:
    """How the rates of the same scenarios differ between two inputs, second minus first.

    Intervals are 95 % percentile intervals of a bootstrap that draws scenarios, with all their
    records and pairs together; ``mcnemar_p`` is McNemar's exact test on which scenarios were driven
    safely, None where a scenario stands for several records, which depend on each other.

    Args:
        first: Records.
        second: Records of the same scenarios and intentions in the same order.
        resamples: Bootstrap samples.
        seed: Seed of the bootstrap.

    Raises:
        ValueError: The scenarios differ.
    """
    names = [(r.scenario, r.intention) for r in first]
    if names != [(r.scenario, r.intention) for r in second]:
        raise ValueError("paired records belong to the same scenarios in the same order")
    outcomes = {SAFE: 0, COLLISION: 1, UNPLANNED: 2}
    pairs = np.array(
        [3 * outcomes[a.outcome] + outcomes[b.outcome] for a, b in zip(first, second, strict=True)],
        int,
    )
    if not len(pairs):
        return {"scenarios": 0}
    _, scenario = np.unique([name for name, _ in names], return_inverse=True)
    by_scenario = np.zeros((int(scenario.max()) + 1, 9), int)
    np.add.at(by_scenario, (scenario, pairs), 1)
    counts = by_scenario.sum(axis=0)
    # Scenarios with equal outcomes are drawn together.
    patterns, multiplicity = np.unique(by_scenario, axis=0, return_counts=True)
    draws = np.random.default_rng(seed).multinomial(
        len(by_scenario), multiplicity / len(by_scenario), size=resamples
    )
    observed, drawn = _rate_differences(counts[None]), _rate_differences(draws @ patterns)
    result: dict[str, Any] = {"scenarios": len(by_scenario), "drives": len(pairs)}
    for name in observed:
        result[name] = _finite(float(observed[name][0]))
        sample = drawn[name][np.isfinite(drawn[name])]
        result[f"{name}_interval"] = (
            [float(q) for q in np.quantile(sample, [0.025, 0.975])] if len(sample) else None
        )
    table = counts.reshape(3, 3)
    lost, gained = int(table[0, 1:].sum()), int(table[1:, 0].sum())
    result["became_unsafe"], result["became_safe"] = lost, gained
    result["mcnemar_p"] = mcnemar_p(lost, gained) if len(by_scenario) == len(pairs) else None
    return result


def with_corrected_p(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of a table of `paired_differences`, ``mcnemar_p_holm`` beside each ``mcnemar_p``.

    Holm's correction for all rows that have one: where a table has many, some p-values are small by
    chance.

    Example:
        >>> with_corrected_p([{"mcnemar_p": 0.02}, {"mcnemar_p": 0.5}, {"mcnemar_p": None}])[0]
        {'mcnemar_p': 0.02, 'mcnemar_p_holm': 0.04}
    """
    known = [np.nan if row.get("mcnemar_p") is None else row["mcnemar_p"] for row in rows]
    return [
        {**row, "mcnemar_p_holm": _finite(float(p))}
        for row, p in zip(rows, holm_adjusted(known), strict=True)
    ]


def _rate_differences(counts: np.ndarray) -> dict[str, np.ndarray]:
    table = counts.reshape(-1, 3, 3).astype(float)
    total = table.sum(axis=(1, 2))
    rates = []
    with np.errstate(invalid="ignore", divide="ignore"):
        for margin in (table.sum(axis=2), table.sum(axis=1)):
            safe, collided = margin[:, 0], margin[:, 1]
            planned = safe + collided
            rates.append((planned / total, collided / planned, safe / total))
    names = ("success_rate", "collision_rate", "safe_driving_rate")
    return {name: rates[1][i] - rates[0][i] for i, name in enumerate(names)}


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
