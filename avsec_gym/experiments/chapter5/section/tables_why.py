"""Tables of the thesis' reasons (section 5.5): where ghosts are, how far patches spread, SPP."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

from avsec_gym.drawing.page_table import UNKNOWN, Table, TableCell, figure, name, number
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.ghost_shares import GhostRow
from avsec_gym.experiments.chapter5.patch_spreads import (
    IMAGES,
    NOISE,
    PATCHES,
    SCENES,
    SpreadRow,
)
from avsec_gym.experiments.chapter5.pyramid import PyramidRow
from avsec_gym.experiments.chapter5.section.estimate_cell import estimate_cell
from avsec_gym.experiments.chapter5.settings import UNATTACKED, WITHOUT_PYRAMID
from avsec_gym.experiments.chapter5.trained import TRAINED_PATCHES

PATCH_WORDS = {"patch": "own patch", "joint": "joint patch", NOISE: "patch of noise (control)"}
"""What patches are called."""
IMAGE_WORDS = {NOISE: "on noise", SCENES: "on scenes"}


def ghost_table(rows: Sequence[GhostRow]) -> Table:
    """The share of ghosts on the road and beside it, and what chance would give."""
    lines = []
    for row in rows:
        condition, found = row.condition, row.summary
        lines.append(
            [
                name(detector_name(condition.detector)),
                name(attack_name(condition.attack, condition.strength)),
                TableCell(number(found.ghosts, digits=0), key=found.ghosts),
                estimate_cell(found.share_on_road, scale=100),
                estimate_cell(found.chance, scale=100),
                estimate_cell(found.ratio, digits=2),
                estimate_cell(found.share_in_lanes, scale=100),
                figure(found.unknown / found.ghosts if found.ghosts else None, scale=100),
            ]
        )
    return Table(
        "Section 5.5.1: ghosts on the road and beside it",
        ["detector", "attack", "ghosts", "on the road, %", "by chance, %", "odds ratio",
         "in the driven lanes, %", "neither, %"],
        lines,
        "Ghosts up to 40 m ahead that are planned on. Where one stands is what the left image"
        " shows at its foot; “neither” is out of the image or hidden by another object, and"
        " does not count. By chance: the road’s share of the ground that is seen. Odds ratio: 1"
        " where ghosts do not care, below 1 where they prefer the side area. In the driven lanes:"
        " on the road and reaching into one of the three lanes that the car may take. In brackets:"
        " 95 % bootstrap intervals over scenarios.",
        names=2,
    )  # fmt: skip


def spread_table(rows: Sequence[SpreadRow]) -> Table:
    """Figure 5.8 in numbers: radii in multiples of the patch's."""
    shown = {(row.patch, row.images) for row in rows}
    columns = [column for column in product(PATCHES, IMAGES) if column in shown]
    found = {(row.detector, row.layer, row.patch, row.images): row for row in rows}
    lines = []
    for detector, layer in dict.fromkeys((row.detector, row.layer) for row in rows):
        cells, reach = [], TableCell(UNKNOWN)
        for patch, images in columns:
            row = found.get((detector, layer, patch, images))
            if row is None:
                cells += [TableCell(UNKNOWN)] * 2
                continue
            radii = (row.extent.radius, row.extent.radius_absolute)
            cells += [figure(radius / row.patch_radius) for radius in radii]
            reach = figure(row.extent.reach / row.patch_radius)
        lines.append([name(detector_name(detector)), name(layer), *cells, reach])
    return Table(
        "Figure 5.8: how far a patch spreads, in multiples of its radius",
        ["detector", "layer", *("by its maximum", "by another image") * len(columns), "can reach"],
        lines,
        "Radius of a disc with the area, of a central square of 240 pixels, where the patch changes"
        " a layer’s output by more than a tenth: of its largest change there, or of what another"
        " image changes on average, which makes layers comparable. The largest that fits is 3.6."
        " Can reach: as far as convolutions and pooling carry anything."
        " Means over four images, or as many as there are."
        f" {' '.join(left_out(rows))}",
        [("", 2), *((f"{PATCH_WORDS[p]} {IMAGE_WORDS[i]}", 2) for p, i in columns), ("", 1)],
        names=2,
    )  # fmt: skip


def left_out(rows: Sequence[SpreadRow]) -> list[str]:
    """Remarks on what `spread_table` lacks because files were not given."""
    remarks = []
    detectors = dict.fromkeys(row.detector for row in rows)
    if WITHOUT_PYRAMID not in detectors:
        remarks.append(
            "DSGN without its spatial pyramid pooling is left out: no weights were given"
            f" (--options {WITHOUT_PYRAMID}=FILE)."
        )
    for kind in TRAINED_PATCHES:
        without = [
            detector_name(detector)
            for detector in detectors
            if not any(row.detector == detector and row.patch == kind for row in rows)
        ]
        if without:
            remarks.append(f"There was no file of the {PATCH_WORDS[kind]} of {', '.join(without)}.")
    return remarks


def pyramid_table(rows: Sequence[PyramidRow]) -> Table:
    """DSGN with its spatial pyramid pooling and without."""
    lines = []
    for row in rows:
        cells = [name(attack_name(row.attack))]
        for what in ("precision", "safety"):
            cells += [
                estimate_cell(row.figures[f"{what}_{which}"]) for which in ("with", "without")
            ]
            more = row.figures[f"{what}_difference"]
            unattacked = row.attack == UNATTACKED
            cells.append(TableCell(UNKNOWN) if unattacked else estimate_cell(more, signed=True))
        lines.append(cells)
    return Table(
        "Section 5.5.2: DSGN with its spatial pyramid pooling (SPP), and without",
        ["attack", *("with", "without", "more taken without") * 2],
        lines,
        "More taken without: what the patch takes of the network without SPP, less what it takes of"
        " the one with it, in percentage points; above 0 where SPP protects. Random and specific"
        " patches are each network’s own; the joint one was trained for DSGN with SPP and Stereo"
        " R-CNN. AP: cars in 3D, IoU 0.7, moderate, 11 recall points. In brackets: 95 % bootstrap"
        " intervals over the same scenarios.",
        [("", 1), ("average precision, %", 3), ("safe driving, %", 3)],
    )
