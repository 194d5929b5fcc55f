"""Rows of buildings and what stands before them, on one side of a road."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.buildings import garden_wall, make_building, picket_fence
from avsec_gym.world.scenery.planting import plant_bushes, plant_hedge, plant_trees
from avsec_gym.world.scenery.plot import Make, Plot
from avsec_gym.world.section import Surface

HOUSES = 24
"""Different houses of one kind and size: some thousands in all."""


@dataclass(frozen=True)
class BuildingRow:
    """How buildings stand along a road.

    Args:
        kinds: Kinds of building and their shares.
        widths: Smallest and largest, metres.
        depths: Smallest and largest, metres.
        setback: Smallest and largest distance between the road's edge and the facades, metres.
        gap: Smallest and largest space between neighbours, metres.
        gap_share: Share of neighbours with a gap; the others adjoin.
    """

    kinds: dict[str, float]
    widths: tuple[float, float]
    depths: tuple[float, float]
    setback: tuple[float, float]
    gap: tuple[float, float]
    gap_share: float = 1.0


def build_row(
    plot: Plot,
    rng: np.random.Generator,
    row: BuildingRow,
    side: int,
    *,
    before: Callable[[float, float, float], None] | None = None,
) -> list[float]:
    """Buildings along one side, as far as there is room; returns the middles of the gaps.

    Where something stands in the way a building moves back, up to 14 m, or is left out.

    Args:
        plot: The plot that is built up.
        rng: The source of chance.
        row: How.
        side: Side of the course: 1 left, -1 right.
        before: Furnishes the strip before a building: its middle along the road, its width, and
            its setback from the road's edge.
    """
    edge = abs(plot.site.section.edges[1 if side > 0 else 0])
    names, shares = list(row.kinds), np.array(list(row.kinds.values()))
    along = plot.start + float(rng.uniform(0.0, 6.0))
    line = float(rng.uniform(*row.setback))
    gaps: list[float] = []
    while along < plot.end:
        kind = str(rng.choice(names, p=shares / shares.sum()))
        width, depth = _whole(rng, row.widths), _whole(rng, row.depths)
        if kind == "garage":
            width, depth = float(rng.choice([6.0, 9.0, 12.0])), 6.0
        jitter = 0.15 if row.gap_share < 0.6 else 1.0
        setback = max(line + float(rng.normal(0.0, jitter)), row.setback[0])
        middle = along + 0.5 * width
        make = house(plot, rng, kind, width, depth)
        for retreat in (0.0, 2.5, 6.0, 10.0, 14.0):
            if plot.place(
                make,
                Surface.BUILDING,
                middle,
                side * (edge + setback + retreat),
                heading=0.0 if side > 0 else np.pi,
                size=(width - 0.1, depth),
                offset=0.5 * depth,
                sunk=-0.05,
            ):
                if before is not None:
                    before(middle, width, setback + retreat)
                break
        else:
            gaps.append(middle)
        along += width
        if rng.random() < row.gap_share:
            gap = float(rng.uniform(*row.gap))
            gaps.append(along + 0.5 * gap)
            along += gap
    return gaps


def build_behind(
    plot: Plot, rng: np.random.Generator, side: int, gaps: Sequence[float], kinds: Sequence[str]
) -> None:
    """Houses of the next street, seen through gaps of a row.

    Args:
        plot: The plot that is built up.
        rng: The source of chance.
        side: Side of the course: 1 left, -1 right.
        gaps: Middles of the gaps along the road, as `build_row` returns them.
        kinds: Kinds of buildings, each as likely as the others.
    """
    edge = abs(plot.site.section.edges[1 if side > 0 else 0])
    for along in gaps:
        kind, width = str(rng.choice(list(kinds))), _whole(rng, (14.0, 26.0))
        plot.place(
            house(plot, rng, kind, width, 11.0),
            Surface.BUILDING,
            along + float(rng.uniform(-4.0, 8.0)),
            side * (edge + float(rng.uniform(24.0, 36.0))),
            heading=0.0 if side > 0 else np.pi,
            size=(width, 11.0),
            offset=5.5,
            sunk=-0.05,
        )


def _whole(rng: np.random.Generator, span: tuple[float, float]) -> float:
    """A whole number of metres in a range."""
    return float(np.round(rng.uniform(*span)))


def house(plot: Plot, rng: np.random.Generator, kind: str, width: float, depth: float) -> Make:
    """One of the `HOUSES` of a kind and size, of the place's part of the assets."""
    return partial(_building, kind, width, depth, plot.draw(rng, f"building/{kind}", HOUSES))


def _building(kind: str, width: float, depth: float, seed: int, distance: float) -> Mesh:
    return _built(kind, width, depth, seed)


@lru_cache(maxsize=2048)
def _built(kind: str, width: float, depth: float, seed: int) -> Mesh:
    """A house is made once; it comes again in other streets, beside others."""
    return make_building(kind, width, depth, np.random.default_rng(seed))


def front_garden(
    plot: Plot, rng: np.random.Generator, side: int, species: Sequence[str]
) -> Callable[[float, float, float], None]:
    """Walls, fences or hedges on the border of the pavement, with plants behind."""
    edge = abs(plot.site.section.edges[1 if side > 0 else 0])
    usual = str(rng.choice(["wall", "fence", "hedge", "open"], p=[0.35, 0.2, 0.3, 0.15]))

    def furnish(middle: float, width: float, setback: float) -> None:
        if setback < 1.6:
            return
        kind = usual if rng.random() < 0.7 else str(rng.choice(["wall", "fence", "hedge", "open"]))
        # The border, with an opening for a drive at one end.
        drive = float(rng.uniform(2.6, 3.6))
        length = width - drive + float(rng.uniform(0.0, 3.0))
        where = middle + (0.5 * drive if rng.random() < 0.5 else -0.5 * drive)
        border = side * (edge + 0.35)
        turn = 0.0 if side > 0 else np.pi
        if kind == "hedge":
            plant_hedge(plot, rng, where, side * (edge + 0.6), length, float(rng.uniform(0.8, 2.1)))
        elif kind in ("wall", "fence"):
            make = garden_wall if kind == "wall" else picket_fence
            plot.place(
                make(length, rng),
                Surface.BUILDING if kind == "wall" else Surface.FURNITURE,
                where,
                border,
                heading=turn,
                size=(length, 0.35),
            )
        # Bushes and a tree before the house, a tree behind it.
        count = int(rng.poisson(0.12 * width * min(setback, 8.0) / 4.0))
        stations = middle + width * rng.uniform(-0.6, 0.6, count)
        plant_bushes(plot, rng, stations, side * (edge + rng.uniform(1.3, setback, count)))
        if setback > 3.0 and rng.random() < 0.55:
            plant_trees(
                plot,
                rng,
                species,
                [middle + width * float(rng.uniform(-0.6, 0.6))],
                [side * (edge + setback * float(rng.uniform(0.35, 0.8)))],
                scale=(0.5, 1.0),
            )
        if rng.random() < 0.6:
            plant_trees(
                plot,
                rng,
                species,
                [middle + width * float(rng.uniform(-0.7, 0.7))],
                [side * (edge + setback + float(rng.uniform(12.0, 22.0)))],
                scale=(0.8, 1.3),
            )

    return furnish
