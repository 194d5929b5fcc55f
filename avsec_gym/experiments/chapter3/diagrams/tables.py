"""The diagrams' figures as tables, with their intervals and the thesis' figures."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import Table, TableCell, figure, name, number
from avsec_gym.experiments.chapter3.diagrams.object_rates import ObjectRates
from avsec_gym.experiments.chapter3.diagrams.plots import (
    BEAMS,
    DETECTOR_WORDS,
    MATCHER_WORDS,
    RULE_WORDS,
    scan_words,
)
from avsec_gym.experiments.chapter3.diagrams.summary import (
    NO_CHANGE,
    RULES,
    BenignRow,
    DiagramRow,
    DiagramsSummary,
)
from avsec_gym.experiments.chapter3.diagrams.thesis_marks import (
    thesis_believed,
    thesis_detected,
    thesis_mismatched,
    thesis_named,
)
from avsec_gym.experiments.chapter3.diagrams.variant import FORMS, LIGHTS, Variant, is_of_lidar
from avsec_gym.experiments.chapter3.identification.tables import INTERVALS
from avsec_gym.experiments.chapter3.objects.sensitivity_curves import disc_share
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.rig import KITTI_SIZE


def tables_of_diagrams(summary: DiagramsSummary) -> list[Table]:
    """All tables of a run.

    Args:
        summary: The results of a run.
    """
    tables = [
        _table_of_attacks("Bogus objects", ["form", "points", "scan"], summary, of_lidar=True),
        _table_of_attacks("Lights", ["light", "radius", "peak"], summary, of_lidar=False),
        *([_table_of_changes(summary.benign)] if summary.benign else []),
    ]
    if summary.objects is not None:
        tables += [_table_of_beliefs(summary.objects), _table_of_mismatches(summary.objects)]
    return [table for table in tables if table.rows]


def _table_of_attacks(
    title: str, axes: Sequence[str], summary: DiagramsSummary, *, of_lidar: bool
) -> Table:
    rows = [
        [name(MATCHER_WORDS[row.matcher]), *_axes(row.variant, row.points), *_rates(row)]
        for row in summary.attacks
        if is_of_lidar(row.variant) == of_lidar
    ]
    rules = [RULE_WORDS[rule] for rule in RULES]
    return Table(
        f"{title}: detected, and the sensor named, at r = {100 * summary.rate:g} %, %",
        ["matcher", *axes, *(f"detected: {rule}" for rule in rules), *(f"named: {rule}" for rule
         in rules)],
        rows,
        note=f"{INTERVALS} *Italics*: the thesis, of all its attack cases. Detected: by the LiDAR"
        " and two cameras, by likelihood by four sensors; named: exactly the attacked one of four.",
        names=4,
        sortable=True,
        filters=(0, 1),
        folded=True,
    )  # fmt: skip


def _axes(variant: Variant, points: float | None = None) -> list[TableCell]:
    """The three axes of an attack."""
    if is_of_lidar(variant):
        count = number(variant.amount, digits=0) if variant.amount else BEAMS
        if not variant.amount and points is not None:
            count += f" ({number(points, digits=0)})"
        return [name(FORMS[variant.kind]), name(count), name(scan_words(variant.scan))]
    area = number(disc_share(variant.size * KITTI_SIZE[0]), 100, 1)
    radius = f"{number(variant.size, 100, 1)} % of the width ({area} % of the area)"
    return [name(LIGHTS[variant.kind]), name(radius), name(number(variant.amount, digits=0))]


def _rates(row: DiagramRow) -> list[TableCell]:
    thesis = {"detected": thesis_detected(row.variant), "named": thesis_named(row.variant)}
    return [
        _share(shares[rule], thesis[what] if rule == "error" else None)
        for what, shares in (("detected", row.detected), ("named", row.named))
        for rule in RULES
    ]


def _table_of_changes(rows: Sequence[BenignRow]) -> Table:
    words = {NO_CHANGE: "none"}
    return Table(
        "False alarms under changes that are no attack, %",
        ["matcher", "change of one camera", *(RULE_WORDS[rule] for rule in RULES),
         *(f"some sensor named: {RULE_WORDS[rule]}" for rule in RULES)],
        [
            [
                name(MATCHER_WORDS[row.matcher]),
                name(words.get(row.change, row.change)),
                *(_share(row.alarms[rule]) for rule in RULES),
                *(_share(row.named[rule]) for rule in RULES),
            ]
            for row in rows
        ],
        note=INTERVALS,
        names=2,
        sortable=True,
        filters=(0,),
    )  # fmt: skip


def _table_of_beliefs(objects: ObjectRates) -> Table:
    return Table(
        "Bogus objects that are taken for obstacles, %",
        ["detector", "form", "points", "scan", "taken", "not there without the attack"],
        [
            [
                name(DETECTOR_WORDS.get(row.detector, row.detector)),
                *_axes(row.variant),
                _share(row.taken, thesis_believed(row.variant, row.detector)),
                _share(row.newly),
            ]
            for row in objects.believed
        ],
        note=f"{INTERVALS} *Italics*: the thesis.",
        names=4,
        sortable=True,
        filters=(0, 1),
        folded=True,
    )


def _table_of_mismatches(objects: ObjectRates) -> Table:
    none = [name("none"), name("–")]
    return Table(
        "Attacks that mismatches of objects reveal, LiDAR and two cameras, %",
        ["IoU", "attack", "amount", "size or scan", "mismatches allowed", "alarms"],
        [
            [
                name(f"{row.iou:g}"),
                *(
                    [*none, name(scan_words(row.scan))]
                    if row.variant is None
                    else _axes(row.variant)
                ),
                TableCell(str(row.most), key=row.most),
                _share(row.alarms, thesis_mismatched(row.variant, row.iou)),
            ]
            for row in objects.mismatches
        ],
        note=f"Objects that are misplaced in, or missing from, one sensor. {INTERVALS} *Italics*:"
        " the thesis, of all its attack cases.",
        names=4,
        sortable=True,
        filters=(0, 1),
        folded=True,
    )


def _share(share: Share, thesis: float | None = None) -> TableCell:
    return figure(share.rate, share.interval, thesis, scale=100)
