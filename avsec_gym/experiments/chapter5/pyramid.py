"""Is it the spatial pyramid pooling that protects DSGN?  The same network without it, patched."""

from __future__ import annotations

from collections.abc import Mapping

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.decoupling import Sampled, precision, safety
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.settings import (
    DSGN,
    JOINT_PATCHES,
    PATCHES,
    UNATTACKED,
    WITHOUT_PYRAMID,
)
from avsec_gym.experiments.chapter5.tables import Row
from avsec_gym.runs.results import Results

MEASURES = {"precision": precision, "safety": safety}


def pyramid_rows(results: Results, labels: Mapping[str, Boxes3D]) -> list[Row]:
    """Precision and safe driving with the pyramid and without, unattacked and under each patch.

    ``taken`` is what a patch takes, in percentage points; ``difference`` how much more it takes
    without the pyramid than with it.  Intervals hold 95 % of a bootstrap over scenarios, which are
    the same for both.

    Args:
        results: Of a run.
        labels: What is to be seen in each scenario.
    """
    outcomes = Outcomes(results, labels, (DSGN, WITHOUT_PYRAMID))
    rows: list[Row] = []
    for attack in (UNATTACKED, *PATCHES, *JOINT_PATCHES):
        conditions = [Condition(name, attack) for name in outcomes.detectors]
        if not {*conditions, *(one.unattacked for one in conditions)} <= {*outcomes.conditions}:
            continue
        row: Row = {"attack": attack, "scenarios": len(outcomes.scenarios)}
        for name, measure in MEASURES.items():
            after = [measure(outcomes, one) for one in conditions]
            before = [measure(outcomes, one.unattacked) for one in conditions]
            taken = [clean - left for clean, left in zip(before, after, strict=True)]
            for which, value, lost in zip(("with", "without"), after, taken, strict=True):
                row |= _figures(f"{name}_{which}", value) | _figures(f"{name}_taken_{which}", lost)
            row |= _figures(f"{name}_difference", taken[1] - taken[0])
        rows.append(row)
    return rows


def _figures(name: str, one: Sampled) -> Row:
    return {name: one.value, f"{name}_interval": one.interval}
