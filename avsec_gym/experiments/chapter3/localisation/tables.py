"""How well damage is located and repaired, as a table."""

from __future__ import annotations

from avsec_gym.drawing.page_table import Table, figure, name
from avsec_gym.experiments.chapter3.localisation.rates import BOGUS_SEEN, SUMS, LocalisationSummary
from avsec_gym.experiments.chapter3.objects.tables import detector_words

_SHARES = ("precision", "recall", "iou_of_lost")
_BOGUS = ("bogus obstacle clean, %", "attacked, %", "repaired, %")
_FOUND = ("objects", "found attacked", "not refilled", "found repaired")


def table_of_localisation(summary: LocalisationSummary) -> Table:
    """A row for each attack.

    Args:
        summary: The rows of a run.
    """
    scores = {
        summary.detector: summary.score_threshold,
        summary.scan_detector: summary.scan_score_threshold,
    }
    detectors = {detector: score for detector, score in scores.items() if detector}
    counting = " or ".join(
        f"{detector_words(detector)} (scores from {score:g} on)"
        for detector, score in detectors.items()
    )
    columns = [
        *("attack", "frames", "IoU, %", "lowest, %", "precision, %", "recall, %"),
        *("IoU of lost returns, %", "error attacked", "error repaired"),
        *(_FOUND if detectors else ()),
        *(_BOGUS if summary.scan_detector else ()),
    ]
    lines = [
        [
            name(row.attack),
            figure(row.frames, digits=0),
            figure(row.iou, row.interval, scale=100),
            figure(None if row.lowest is None else row.lowest.iou, scale=100),
            *(figure(getattr(row, name_of_share), scale=100) for name_of_share in _SHARES),
            *(figure(row.error_before), figure(row.error_after)),
            *(
                figure(getattr(row, name_of_sum), digits=0)
                for name_of_sum in (SUMS if detectors else ())
            ),
            *(
                figure(getattr(row, name_of_share), scale=100)
                for name_of_share in (BOGUS_SEEN if summary.scan_detector else ())
            ),
        ]
        for row in summary.attacks
    ]
    counted = (
        f" Objects: that {counting} finds in the clean images or"
        " scans, and how many of them it finds again, 2D IoU 0.5 or more, in the attacked and the"
        " repaired ones; not refilled: in scans that only lack what was found bogus."
        if detectors
        else ""
    )
    if summary.scan_detector:
        counted += (
            f" Bogus obstacle: in how many frames {detector_words(summary.scan_detector)} sees"
            " one where the bogus points are, half covered or more."
        )
    return Table(
        "Damage located and repaired, the attacked sensor named",
        columns,
        lines,
        "IoU, precision, recall: of the pixels or points found damaged, beside the true ones; means"
        " over frames, precision over those in which something was found; in brackets: 95 %"
        " intervals by bootstrap over drives. Errors: mean difference to the clean image where it"
        f" was damaged, grey levels, before and after the repair.{counted}",
    )
