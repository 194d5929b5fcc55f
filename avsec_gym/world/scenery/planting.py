"""Trees, bushes and hedges on a plot."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, partial

import numpy as np

from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.plants import BUSHES, HEDGES, VARIANTS, Detail, bush, hedge, tree
from avsec_gym.world.scenery.plot import Make, Plot
from avsec_gym.world.section import Surface

_MIDDLE, _FAR = 26.0, 55.0


def tree_maker(species: str, variant: int, hidden: float = 0.0) -> Make:
    """A tree whose detail falls with distance; half-hidden ones count as farther, by metres."""
    return partial(_tree, species, variant, hidden)


def plant_trees(
    plot: Plot,
    rng: np.random.Generator,
    species: Sequence[str],
    along: Sequence[float] | np.ndarray,
    left: Sequence[float] | np.ndarray,
    *,
    on_road: bool = False,
    scale: tuple[float, float] = (0.8, 1.2),
    hidden: float = 0.0,
) -> int:
    """Trees at places; returns how many had room (see `tree_maker` for `hidden`)."""
    planted = 0
    for station, offset in zip(along, left, strict=True):
        kind = str(rng.choice(list(species)))
        variant = plot.draw(rng, f"plant/{kind}", VARIANTS)
        size, turn = float(rng.uniform(*scale)), float(rng.uniform(0, 2 * np.pi))
        planted += plot.place(
            tree_maker(kind, variant, hidden),
            Surface.VEGETATION,
            float(station),
            float(offset),
            heading=turn,
            size=(0.7, 0.7),
            scale=size,
            on_road=on_road,
        )
    return planted


def plant_bushes(
    plot: Plot,
    rng: np.random.Generator,
    along: Sequence[float] | np.ndarray,
    left: Sequence[float] | np.ndarray,
    *,
    scale: tuple[float, float] = (0.6, 1.3),
    on_road: bool = False,
) -> None:
    """Bushes at places; `on_road` for those on a median."""
    for station, offset in zip(along, left, strict=True):
        variant = plot.draw(rng, "plant/bush", BUSHES)
        size, turn = float(rng.uniform(*scale)), float(rng.uniform(0, 2 * np.pi))
        plot.place(
            partial(_bush, variant),
            Surface.VEGETATION,
            float(station),
            float(offset),
            heading=turn,
            size=(1.2, 1.2),
            scale=size,
            on_road=on_road,
        )


def plant_hedge(
    plot: Plot, rng: np.random.Generator, along: float, left: float, length: float, height: float
) -> bool:
    """A clipped hedge along the road, from its middle."""
    depth = float(rng.uniform(0.6, 1.0))
    return plot.place(
        partial(_hedge, length, height, depth, plot.draw(rng, "plant/hedge", HEDGES)),
        Surface.VEGETATION,
        along,
        left,
        size=(length, depth),
    )


def grove(
    plot: Plot,
    rng: np.random.Generator,
    species: Sequence[str],
    *,
    side: int,
    nearest: float,
    deepest: float,
    spacing: float,
) -> None:
    """A belt of trees and bushes beside the road, dense as a wood's edge.

    Args:
        plot: The plot that is planted.
        rng: The source of chance.
        species: Species of the trees.
        side: Side of the course: 1 left, -1 right.
        nearest: Distance of the belt from the course, metres.
        deepest: The far edge.
        spacing: Mean distance between trees, metres.
    """
    area = (plot.end - plot.start) * (deepest - nearest)
    count = int(area / spacing**2)
    along = rng.uniform(plot.start, plot.end, count)
    depth = nearest + (deepest - nearest) * rng.random(count) ** 1.4
    front = depth < nearest + 7.0
    plant_trees(plot, rng, species, along[front], side * depth[front])
    plant_trees(plot, rng, species, along[~front], side * depth[~front], hidden=_MIDDLE)
    edge = int((plot.end - plot.start) / (1.3 * spacing))
    along = rng.uniform(plot.start, plot.end, edge)
    plant_bushes(plot, rng, along, side * (nearest + rng.uniform(-1.5, 2.0, edge)))


def _tree(species: str, variant: int, hidden: float, distance: float) -> Mesh:
    return tree(species, variant, _detail(distance + hidden))


def _bush(variant: int, distance: float) -> Mesh:
    return bush(variant, _detail(distance + 0.5 * _MIDDLE))


@lru_cache(maxsize=256)
def _cut(length: float, height: float, depth: float, variant: int, detail: Detail) -> Mesh:
    return hedge(length, height, depth, variant, detail)


def _hedge(length: float, height: float, depth: float, variant: int, distance: float) -> Mesh:
    return _cut(length, height, depth, variant, _detail(distance + 0.3 * _MIDDLE))


def _detail(distance: float) -> Detail:
    return "near" if distance < _MIDDLE else "middle" if distance < _FAR else "far"
