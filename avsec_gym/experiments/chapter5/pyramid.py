"""Is it the spatial pyramid pooling that protects DSGN?  The same network without it, patched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.losses import precision, safety
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    DSGN,
    JOINT_PATCHES,
    PATCHES,
    UNATTACKED,
    WITHOUT_PYRAMID,
)
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.runs.results import Results

MEASURES = {"precision": precision, "safety": safety}


@dataclass(frozen=True)
class PyramidRow:
    """Both networks under an attack, percent and percentage points.

    Args:
        attack: The patch, or ``unattacked``.
        scenarios: Number of scenarios, which are the same for both.
        figures: The figures by name: ``precision_with``, ``precision_without`` (the pyramid),
            ``precision_taken_with``, ``precision_taken_without`` (what the patch takes), and
            ``precision_difference`` (how much more it takes without the pyramid); of ``safety``
            likewise.
    """

    attack: str
    scenarios: int
    figures: Mapping[str, Estimate] = field(metadata=FLAT)


def pyramid_rows(results: Results, labels: Mapping[str, Boxes3D]) -> list[PyramidRow]:
    """Precision and safe driving with the pyramid and without, unattacked and under each patch.

    Intervals hold 95 % of a bootstrap over scenarios.

    Args:
        results: The results of a run.
        labels: The labels of each scenario.
    """
    outcomes = Outcomes(results, labels, (DSGN, WITHOUT_PYRAMID))
    rows: list[PyramidRow] = []
    for attack in (UNATTACKED, *PATCHES, *JOINT_PATCHES):
        conditions = [Condition(name, attack) for name in outcomes.detectors]
        needed = {*conditions, *(condition.unattacked for condition in conditions)}
        if needed <= {*outcomes.conditions}:
            row = PyramidRow(attack, len(outcomes.scenarios), _figures(outcomes, conditions))
            rows.append(row)
    return rows


def _figures(outcomes: Outcomes, conditions: list[Condition]) -> dict[str, Estimate]:
    """Those of a row; the first condition is with the pyramid, the second without."""
    figures: dict[str, Estimate] = {}
    for name, measure in MEASURES.items():
        after = [measure(outcomes, condition) for condition in conditions]
        before = [measure(outcomes, condition.unattacked) for condition in conditions]
        taken = [clean - attacked for clean, attacked in zip(before, after, strict=True)]
        for which, reached, lost in zip(("with", "without"), after, taken, strict=True):
            figures[f"{name}_{which}"] = reached.estimate
            figures[f"{name}_taken_{which}"] = lost.estimate
        figures[f"{name}_difference"] = (taken[1] - taken[0]).estimate
    return figures
