"""How well damage is located and repaired, as a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.experiments.chapter3.localisation.rates import BOGUS_SEEN, LOWEST, SUMS
from avsec_gym.experiments.chapter3.objects.tables import detector_words

_SHARES = ("precision", "recall", "iou_of_lost")
_BOGUS = ("bogus obstacle clean, %", "attacked, %", "repaired, %")
_FOUND = ("objects", "found attacked", "not refilled", "found repaired")
_ERRORS = ("error_before", "error_after")


def table_of_localisation(summary: Mapping[str, Any]) -> Table:
    """A row for each attack.

    Args:
        summary: Of `avsec_gym.experiments.chapter3.localisation.rates.localisation_summary`.
    """
    scores = {"detector": "score_threshold", "scan_detector": "scan_score_threshold"}
    detectors = {summary[one]: summary[score] for one, score in scores.items() if summary[one]}
    told = " or ".join(
        f"{detector_words(one)} (scores from {score:g} on)" for one, score in detectors.items()
    )
    columns = [
        *("attack", "moments", "IoU, %", "lowest, %", "precision, %", "recall, %"),
        *("IoU of lost returns, %", "error attacked", "error repaired"),
        *(_FOUND if detectors else ()),
        *(_BOGUS if summary["scan_detector"] else ()),
    ]
    lines = [
        [
            name(row["attack"]),
            figure(row["moments"], digits=0),
            figure(row["iou"], row["interval"], scale=100),
            figure(row[LOWEST] and row[LOWEST]["iou"], scale=100),
            *(figure(row[one], scale=100) for one in _SHARES),
            *(figure(row[one]) for one in _ERRORS),
            *(figure(row[one], digits=0) for one in (SUMS if detectors else ())),
            *(
                figure(row[one], scale=100)
                for one in (BOGUS_SEEN if summary["scan_detector"] else ())
            ),
        ]
        for row in summary["attacks"]
    ]
    counted = (
        f" Objects: that {told} finds in the clean images or"
        " scans, and how many of them it finds again, 2D IoU 0.5 or more, in the attacked and the"
        " repaired ones; not refilled: in scans that only lack what was found bogus."
        if detectors
        else ""
    )
    if summary["scan_detector"]:
        counted += (
            f" Bogus obstacle: in how many moments {detector_words(summary['scan_detector'])} sees"
            " one where the bogus points are, half covered or more."
        )
    return Table(
        "Damage located and repaired, the attacked sensor named",
        columns,
        lines,
        "IoU, precision, recall: of the pixels or points found damaged, beside the true ones; means"
        " over moments, precision over those in which something was found; in brackets: 95 %"
        " intervals by bootstrap over drives. Errors: mean difference to the clean image where it"
        f" was damaged, grey levels, before and after the repair.{counted}",
    )
