"""An agent or a baseline with its held-out episodes, and trainings of several seeds together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from avsec_gym.agents.arena import Played
from avsec_gym.geometry import Floats
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.interquartile_mean import interquartile_interval, interquartile_mean
from avsec_gym.metrics.paired_scores import PairedDifference, paired_difference
from avsec_gym.metrics.probability_of_improvement import probability_of_improvement

BLOCK = 20
"""Held-out episodes that make a score: their success rate."""


@dataclass(frozen=True, eq=False)
class ComparedAgent:
    """One agent or baseline.

    Args:
        name: The name of the player.
        played: The results of its held-out episodes.
        queries: Environment steps that it learned from, or was searched with.
        training: The results of a baseline's training episodes, by which the best one is chosen;
            None of an agent.
    """

    name: str
    played: Played
    queries: int
    training: Played | None = None

    @property
    def kind(self) -> str:
        """``agent`` or ``baseline``."""
        return "agent" if self.training is None else "baseline"

    @property
    def in_training(self) -> tuple[float, float]:
        """Success rate and mean reward in the training episodes; -1, -inf where it played none."""
        if self.training is None:
            return (-1.0, -math.inf)
        return (float(self.training.success.mean()), float(self.training.reward.mean()))

    @property
    def rate(self) -> float:
        """The success rate."""
        return float(self.played.success.mean())

    @property
    def share(self) -> Share:
        """The successes; episodes of one scene are a cluster of the interval."""
        return share_of(self.played.success, self.played.scenario.tolist())

    @property
    def scores(self) -> Floats:
        """The success rate of each block of episodes; of fewer than a block, of each episode."""
        won = self.played.success.astype(float)
        whole = len(won) // BLOCK * BLOCK
        return np.asarray(won[:whole].reshape(-1, BLOCK).mean(axis=1) if whole else won)

    @property
    def middle(self) -> Estimate:
        """The interquartile mean of the scores."""
        return interquartile_estimate([self])

    def to_json(self) -> dict[str, Any]:
        """Rates, means and their 95 % intervals."""
        return {
            "name": self.name,
            "kind": self.kind,
            "queries": self.queries,
            "episodes": len(self.played.success),
            "success_rate": self.rate,
            "success_interval": list(self.share.interval or ()) or None,
            "interquartile_mean": self.middle.value,
            "interquartile_interval": list(self.middle.interval or ()),
            "reward": float(self.played.reward.mean()),
            "training_success_rate": None if self.training is None else self.in_training[0],
        }


def interquartile_estimate(rows: Sequence[ComparedAgent]) -> Estimate:
    """The interquartile mean of all scores together; its interval is one over rows and blocks.

    Args:
        rows: Trainings, or a single agent or baseline; all have played the same episodes.
    """
    scores = [row.scores for row in rows]
    value = float(interquartile_mean(np.concatenate(scores)))
    return Estimate(value, interquartile_interval(scores))


def improvement(rows: Sequence[ComparedAgent], other: ComparedAgent) -> Estimate:
    """The probability that a training scores above another player in a block of episodes.

    Args:
        rows: Trainings, or a single agent.
        other: Who played the same episodes.
    """
    return probability_of_improvement([row.scores for row in rows], other.scores).estimate


def difference(rows: Sequence[ComparedAgent], other: ComparedAgent) -> PairedDifference:
    """Success of trainings less that of another player, paired over episodes.

    A scene is drawn with its episodes of all trainings.

    Args:
        rows: Trainings, or a single agent.
        other: Who played the same episodes.
    """
    return paired_difference(
        np.concatenate([row.played.success for row in rows]),
        np.tile(other.played.success, len(rows)),
        np.tile(other.played.scenario, len(rows)).tolist(),
    )


@dataclass(frozen=True, eq=False)
class PooledTrainings:
    """Trainings of one configuration with different seeds, judged in the same episodes.

    Args:
        name: The algorithm and the number of seeds.
        seeds: The seed of each training.
        rows: The trainings.
    """

    name: str
    seeds: tuple[int, ...]
    rows: tuple[ComparedAgent, ...]

    def winner(self, best: ComparedAgent, baselines: Sequence[ComparedAgent]) -> str:
        """``agent``, ``baseline`` or ``undecided``, by intervals of interquartile means.

        The trainings win where theirs lies above that of every baseline, and lose where it lies
        below that of the best one.

        Args:
            best: The best baseline.
            baselines: All of them.
        """
        low, high = interquartile_estimate(self.rows).interval or (np.nan, np.nan)
        if low > max((each.middle.interval or (np.nan, np.nan))[1] for each in baselines):
            return "agent"
        return "baseline" if high < (best.middle.interval or (np.nan, np.nan))[0] else "undecided"

    def answer(self, best: ComparedAgent, baselines: Sequence[ComparedAgent]) -> str:
        """Who wins: a sentence.

        Args:
            best: The best baseline.
            baselines: All of them.
        """
        own, theirs = interquartile_estimate(self.rows), best.middle
        means = f"interquartile mean {_percent(own)} against {_percent(theirs)}"
        match self.winner(best, baselines):
            case "agent":
                return f"{self.name}, wins against every baseline, the best {best.name}: {means}"
            case "baseline":
                return f"{best.name} wins against {self.name}: {means} for the baseline"
        return f"undecided between {self.name}, and the best baseline, {best.name}: {means}"

    def to_json(self, best: ComparedAgent, baselines: Sequence[ComparedAgent]) -> dict[str, Any]:
        """Pooled figures with their 95 % intervals, and the comparison with the best baseline.

        Args:
            best: The best baseline.
            baselines: All of them.
        """
        found = difference(self.rows, best)
        return {
            "name": self.name,
            "agents": [row.name for row in self.rows],
            "seeds": list(self.seeds),
            "queries": max(row.queries for row in self.rows),
            "success_rate": float(np.mean([row.rate for row in self.rows])),
            **interquartile_estimate(self.rows).columns("interquartile_mean"),
            "difference": found.difference,
            "interval": found.interval and list(found.interval),
            **improvement(self.rows, best).columns("probability_of_improvement"),
            "winner": self.winner(best, baselines),
            "answer": self.answer(best, baselines),
        }


def _percent(found: Estimate) -> str:
    low, high = found.interval or ()
    return f"{100 * (found.value or 0.0):.1f} % ({100 * low:.1f} to {100 * high:.1f})"
