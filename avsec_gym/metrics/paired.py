"""Two inputs on the same scenarios: differences of the rates with paired intervals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from avsec_gym.metrics.cluster_bootstrap import Sampled
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.intervals import mcnemar_p
from avsec_gym.metrics.many_comparisons import holm_adjusted
from avsec_gym.metrics.safety import (
    COLLISION,
    SAFE,
    UNPLANNED,
    RecordCluster,
    SafetyRecord,
    scenario_of,
)


@dataclass(frozen=True)
class PairedRates:
    """How rates differ between two inputs on the same scenarios; see `paired_differences`.

    Args:
        scenarios: Number of scenarios.
        episodes: Number of episodes; ``drives`` in files, whose format it is.
        success_rate: Difference of the success rate.
        collision_rate: Difference of the collision rate.
        safe_driving_rate: Difference of the safe driving rate.
        became_unsafe: Number of episodes that were safe and are not.
        became_safe: Number of episodes that were not safe and are.
        mcnemar_p: McNemar's exact test; None where a cluster has several episodes.
    """

    scenarios: int
    episodes: int = field(metadata={"key": "drives"})
    success_rate: Estimate
    collision_rate: Estimate
    safe_driving_rate: Estimate
    became_unsafe: int
    became_safe: int
    mcnemar_p: float | None

    def to_json(self) -> dict[str, object]:
        """All of it, the interval of a rate beside the rate."""
        return {
            "scenarios": self.scenarios,
            "drives": self.episodes,
            **self.success_rate.columns("success_rate"),
            **self.collision_rate.columns("collision_rate"),
            **self.safe_driving_rate.columns("safe_driving_rate"),
            "became_unsafe": self.became_unsafe,
            "became_safe": self.became_safe,
            "mcnemar_p": self.mcnemar_p,
        }


def paired_differences(
    first: Sequence[SafetyRecord],
    second: Sequence[SafetyRecord],
    *,
    cluster: RecordCluster = scenario_of,
    resamples: int = 10_000,
    seed: int = 0,
) -> PairedRates | None:
    """How the rates of the same scenarios differ between two inputs, second minus first.

    Intervals are 95 % percentile intervals of a bootstrap that draws clusters, with all their
    records and pairs together.  McNemar's exact test is about which scenarios were driven safely;
    there is none where a cluster has several records, which depend on each other.  One cluster
    alone gives no interval.

    Args:
        first: Records with the first input.
        second: Records of the same scenarios and intentions in the same order.
        cluster: The cluster that a record belongs to, as of `SafetyRates.of`.
        resamples: Bootstrap samples.
        seed: Seed of the bootstrap.

    Returns:
        The differences; None without records.

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
        return None
    _, belongs = np.unique([cluster(record) for record in first], return_inverse=True)
    by_cluster = np.zeros((int(belongs.max()) + 1, 9), int)
    np.add.at(by_cluster, (belongs, pairs), 1)
    counts = by_cluster.sum(axis=0)
    # Clusters with equal outcomes are drawn together.
    patterns, multiplicity = np.unique(by_cluster, axis=0, return_counts=True)
    draws = np.random.default_rng(seed).multinomial(
        len(by_cluster), multiplicity / len(by_cluster), size=resamples
    )
    observed, drawn = _rate_differences(counts[None]), _rate_differences(draws @ patterns)
    if len(by_cluster) < 2:
        # What is drawn of one cluster is always the same.
        drawn = {name: np.full(resamples, np.nan) for name in observed}
    estimates = {name: Sampled(observed[name][0], drawn[name]).estimate for name in observed}
    table = counts.reshape(3, 3)
    lost, gained = int(table[0, 1:].sum()), int(table[1:, 0].sum())
    alone = len(by_cluster) == len(pairs)
    return PairedRates(
        scenarios=len({name for name, _ in names}),
        episodes=len(pairs),
        **estimates,
        became_unsafe=lost,
        became_safe=gained,
        mcnemar_p=mcnemar_p(lost, gained) if alone else None,
    )


def scenario_p(before: Sequence[SafetyRecord], after: Sequence[SafetyRecord]) -> float:
    """The p-value of scenarios' gaining as often as losing, from one input to another.

    A scenario, with all its intentions, gains if more of its episodes are safe: McNemar's exact
    test of scenarios, which does not take its episodes for independent.

    Args:
        before: Records with the first input.
        after: Records of the same scenarios and intentions in the same order.

    Example:
        >>> def of(*outcomes: str) -> list[SafetyRecord]:
        ...     return [
        ...         SafetyRecord(str(n // 2), str(n % 2), outcome, 1.5, 1, 9.0, 1.5)
        ...         for n, outcome in enumerate(outcomes)
        ...     ]
        >>> unsafe, safe = of(*6 * ["collision", "safe"]), of(*12 * ["safe"])
        >>> scenario_p(unsafe, safe), scenario_p(safe, safe)
        (0.03125, 1.0)
    """
    change: Counter[str] = Counter()
    for one, other in zip(before, after, strict=True):
        change[one.scenario] += other.safe - one.safe
    gained, lost = (sum(sign * net > 0 for net in change.values()) for sign in (1, -1))
    return mcnemar_p(lost, gained)


def holm_p(rows: Sequence[PairedRates | None]) -> list[float | None]:
    """McNemar's p of a table's rows after Holm's correction for all rows that have one.

    Where a table has many, some p-values are small by chance.

    Example:
        >>> safe = [SafetyRecord(str(n), "left", SAFE, 0.0, 0, 0.0, 0.0) for n in range(6)]
        >>> stuck = [SafetyRecord(str(n), "left", UNPLANNED, 0.0, 0, 0.0, 0.0) for n in range(6)]
        >>> holm_p([paired_differences(safe, stuck), paired_differences(safe, safe), None])
        [0.0625, 1.0, None]
    """
    known = [np.nan if row is None or row.mcnemar_p is None else row.mcnemar_p for row in rows]
    return [_finite(float(p)) for p in holm_adjusted(known)]


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
