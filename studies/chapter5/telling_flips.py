"""Which measure of perception shows, of one attack, the episodes that it makes unsafe?

Attacks can be ranked by a measure that knows nothing of single scenes.  Here each attack is looked
at by itself: of the episodes that are safe unattacked, does the measure lose more in those that
become unsafe than in those that stay safe?
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from avsec_gym.experiments.chapter5.outcomes import CATEGORY, RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.json_rows import OPTIONAL, keyed
from avsec_gym.geometry import Floats
from avsec_gym.metrics.average_precision import METRICS, MinIou
from avsec_gym.metrics.cluster_bootstrap import ClusterBootstrap, Sampled
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.metrics.roc_curve import concordance
from avsec_gym.scenario.intention import Intention
from studies.chapter5.case_measures import CaseMeasures
from studies.chapter5.measures.scene_precision import scene_precision
from studies.chapter5.telling_measures import (
    MEASURES,
    PRECISION,
    PRECISIONS,
    compared_attacks,
    corrected,
    groups_of,
)


@dataclass(frozen=True)
class FlipRow:
    """How well a measure parts episodes that became unsafe from those that stayed safe.

    Args:
        measure: One of `MEASURES`.
        detector: The detector, or ``both``.
        family: The attacks that count, see `MeasureRow`.
        episodes: Number of episodes that were safe unattacked, over the attacks; ``drives`` in
            files, whose format it is.
        became_unsafe: Number of those that are not under attack.
        scenes: Number of scenes that these are in.
        area: Area under the ROC curve of the measure's loss, within attacks; 0.5 is chance.
        interval: The 95 % interval, by bootstrap over scenarios with all their attacks.
        more: How much larger it is than that of the average precision.
        p_holm: The p-value after Holm's correction, as of `MeasureRow`, of these rows.
    """

    measure: str
    detector: str
    family: str
    episodes: int = field(metadata=keyed("drives"))
    became_unsafe: int
    scenes: int
    area: float | None
    interval: Sequence[float] | None
    more: Estimate
    p_holm: float | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True, eq=False)
class _Episodes:
    """Episodes that were safe unattacked, of one attack."""

    scenario: NDArray[np.int64]
    intention: NDArray[np.int64]
    unsafe: NDArray[np.bool_]


def flip_rows(outcomes: Outcomes, cases: CaseMeasures) -> list[FlipRow]:
    """How well the loss of each measure shows which episodes an attack makes unsafe.

    Args:
        outcomes: The outcomes of a run.
        cases: The measures of the cases, as of `telling_rows`.

    Returns:
        A row for each measure, detector and family, ``both`` and ``all`` among them.
    """
    attacks = compared_attacks(outcomes)
    episodes = {attack: _episodes(outcomes, attack) for attack in attacks}
    scenes = ClusterBootstrap(len(outcomes.scenarios), RESAMPLES)
    rows: list[FlipRow] = []
    p_values: list[float] = []
    usual: dict[tuple[str, str], Sampled] = {}
    for measure in MEASURES:
        # The measure of every case of an attack, and of the same cases unattacked.
        looked = dict.fromkeys([*(attack.unattacked for attack in attacks), *attacks])
        values = {each: _by_case(measure, outcomes, each, cases) for each in looked}
        # Where there is nothing to measure, nothing is lost.
        lost = {
            attack: np.nan_to_num(values[attack.unattacked] - values[attack]) for attack in attacks
        }
        for key, group in groups_of(attacks).items():
            # The episodes of a family's attacks, one after the other, each with its loss.
            own = [episodes[attack] for attack in group]
            scenario, intention, unsafe = (
                np.concatenate([getattr(each, name) for each in own] or [np.zeros(0, int)])
                for name in ("scenario", "intention", "unsafe")
            )
            number = np.repeat(np.arange(len(own)), [len(each.unsafe) for each in own])
            losses = np.array([lost[attack] for attack in group])
            scores = losses[number, scenario, intention] if len(own) else np.zeros(0)
            hits = unsafe.astype(bool)
            # The area under the curve, and what it is beyond that of average precision.
            area = scenes.statistic(partial(_area, scores, hits, number, scenario))
            more = area - usual.setdefault(key, area)
            known = np.isfinite(area.value)
            rows.append(
                FlipRow(
                    measure,
                    *key,
                    episodes=len(hits),
                    became_unsafe=int(hits.sum()),
                    scenes=len(np.unique(scenario[hits])),
                    area=area.value if known else None,
                    interval=area.interval_around if known else None,
                    more=more.estimate if known else NOTHING,
                )
            )
            p_values.append(more.p if known and measure != PRECISION else np.nan)
    return [replace(row, p_holm=p) for row, p in zip(rows, corrected(p_values), strict=True)]


def _area(
    scores: Floats,
    hits: NDArray[np.bool_],
    attack: NDArray[np.int64],
    scenario: NDArray[np.int64],
    weights: NDArray[np.int64],
) -> Floats:
    """Within attacks, of sets in which scenarios count so often, shape (K, scenarios)."""
    return concordance(scores, hits, attack, weights[:, scenario])


def _episodes(outcomes: Outcomes, attack: Condition) -> _Episodes:
    row = {scenario: number for number, scenario in enumerate(outcomes.scenarios)}
    column = {str(intention): number for number, intention in enumerate(Intention)}
    before = {
        (record.scenario, record.intention): record.safe
        for record in outcomes.records(attack.unattacked)
    }
    found = [
        (row[record.scenario], column[record.intention], not record.safe)
        for record in outcomes.records(attack)
        if before[record.scenario, record.intention]
    ]
    scenario, intention, unsafe = np.array(found, np.int64).reshape(-1, 3).T
    return _Episodes(scenario, intention, unsafe.astype(bool))


def _by_case(measure: str, outcomes: Outcomes, condition: Condition, cases: CaseMeasures) -> Floats:
    """The measure by scenario and intention, shape (S, 3); NaN where it has nothing to measure."""
    if measure in PRECISIONS:
        return _precision_by_case(outcomes, condition, PRECISIONS[measure])
    part, whole = np.moveaxis(cases[condition][measure], -1, 0)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(part / whole)


def _precision_by_case(outcomes: Outcomes, condition: Condition, min_iou: MinIou) -> Floats:
    """Average precision of each scene alone; NaN without a car."""
    looks, result = outcomes.looks(condition), np.full((len(outcomes.scenarios), 3), np.nan)
    least = min_iou[CATEGORY][METRICS.index("3d")]
    for column, look in enumerate(looks):
        seen = outcomes.detections(condition, look)
        columns = column if len(looks) > 1 else slice(None)
        result[:, columns] = np.reshape(
            [
                scene_precision(outcomes.labels[scenario], boxes, least)
                for scenario, boxes in zip(outcomes.scenarios, seen, strict=True)
            ],
            result[:, columns].shape if len(looks) > 1 else (-1, 1),
        )
    return result
