"""Highways and country roads."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats, rectangle_polygons
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.furniture.barriers import guard_rail, noise_barrier
from avsec_gym.world.models.furniture.crossings import overpass, sign_gantry
from avsec_gym.world.scenery.frontage import house
from avsec_gym.world.scenery.planting import grove, plant_bushes, plant_trees
from avsec_gym.world.scenery.plot import Plot
from avsec_gym.world.scenery.street_side import line_up, scatter
from avsec_gym.world.section import Surface

_WOODS = ("maple", "lime", "spruce", "pine", "birch", "maple")
_CROWNS = 2.5
"""Room for those of trees beside bridges and gantries, metres."""
_ROADSIDE = ("poplar", "lime", "fruit", "birch", "autumn")


def highway(plot: Plot, manner: np.random.Generator, rng: np.random.Generator) -> None:
    """Guard rails, verges, woods or fields, gantries and bridges."""
    right, left = plot.site.section.edges
    over = manner.random()
    if over < 0.18:
        _bridge(plot, rng)
    elif over < 0.45:
        _gantry(plot, rng)
    for strip in plot.site.section.strips:
        inside = strip.right > right + 1.0 and strip.left < left - 1.0
        if strip.surface == Surface.VERGE and inside:
            middle = 0.5 * (strip.right + strip.left)
            _rail(plot, middle - 0.25, traffic_on_left=False)
            _rail(plot, middle + 0.25, traffic_on_left=True)
            if strip.left - strip.right > 2.5 and manner.random() < 0.5:
                along = np.arange(plot.start, plot.end, float(rng.uniform(4.0, 9.0)))
                row = np.full(len(along), middle + 0.9)
                plant_bushes(plot, rng, along, row, scale=(0.4, 0.8), on_road=True)
    for side in (1, -1):
        edge = abs(plot.site.section.edges[1 if side > 0 else 0])
        outer = _outer_verge(plot, side)
        if manner.random() < 0.55:
            _rail(plot, side * outer, traffic_on_left=side < 0)
        line_up(plot, rng, "delineator", side * (outer + 0.4), 25.0, missing=0.05)
        beyond = str(
            manner.choice(["woods", "bank", "fields", "barrier"], p=[0.45, 0.2, 0.25, 0.1])
        )
        if beyond == "barrier":
            plot.add(
                noise_barrier(_path(plot, side * (edge + 2.0))),
                Surface.FURNITURE,
                (0.0, 0.0),
                np.inf,
            )
        _land(plot, rng, side, edge, beyond)
    scatter(
        plot,
        rng,
        {"highway_sign": 1.0, "billboard": 0.1},
        -1,
        -right - 1.2,
        -right - 0.2,
    )


def rural(plot: Plot, manner: np.random.Generator, rng: np.random.Generator) -> None:
    """A road between fields, woods and an avenue of trees; sometimes a farm."""
    for side in (1, -1):
        edge = abs(plot.site.section.edges[1 if side > 0 else 0])
        outer = _outer_verge(plot, side)
        line_up(plot, rng, "delineator", side * outer, 25.0, missing=0.05)
        if manner.random() < 0.25:
            _rail(plot, side * (outer - 0.1), traffic_on_left=side < 0)
        beyond = str(manner.choice(["woods", "bank", "fields", "avenue"], p=[0.35, 0.2, 0.25, 0.2]))
        if beyond == "avenue":
            along = np.arange(plot.start + 3.0, plot.end, float(rng.uniform(9.0, 16.0)))
            plant_trees(
                plot,
                rng,
                (str(manner.choice(_ROADSIDE)),),
                along,
                np.full(len(along), side * (edge + 1.2)),
            )
        _land(plot, rng, side, edge, beyond)
        scatter(plot, rng, {"country_sign": 1.2, "sign_town": 0.1}, side, edge - 0.9, edge - 0.3)
        if rng.random() < 0.3:
            plot.place(
                house(plot, rng, str(rng.choice(["detached", "hall"])), 16.0, 11.0),
                Surface.BUILDING,
                float(rng.uniform(20, 90)),
                side * (edge + float(rng.uniform(8, 30))),
                heading=0.0 if side > 0 else np.pi,
                size=(16.0, 11.0),
                offset=5.5,
            )


def _land(plot: Plot, rng: np.random.Generator, side: int, edge: float, kind: str) -> None:
    if kind == "woods":
        nearest = edge + float(rng.uniform(3.0, 9.0))
        grove(plot, rng, _WOODS, side=side, nearest=nearest, deepest=nearest + 28.0, spacing=6.5)
    elif kind == "bank":
        count = int(rng.integers(30, 70))
        along = rng.uniform(plot.start, plot.end, count)
        plant_bushes(
            plot, rng, along, side * (edge + rng.uniform(1.0, 6.0, count)), scale=(0.8, 2.2)
        )
        trees = int(rng.integers(4, 16))
        plant_trees(
            plot,
            rng,
            _WOODS,
            rng.uniform(plot.start, plot.end, trees),
            side * (edge + rng.uniform(4.0, 16.0, trees)),
        )
    else:
        trees = int(rng.integers(2, 10))
        plant_trees(
            plot,
            rng,
            _ROADSIDE,
            rng.uniform(plot.start, plot.end, trees),
            side * (edge + rng.uniform(6.0, 60.0, trees)),
        )
        for _ in range(int(rng.integers(1, 5))):
            # Bushes stand together, along the borders of fields.
            count = int(rng.integers(2, 12))
            along = rng.uniform(plot.start, plot.end) + rng.normal(0.0, 6.0, count)
            away = edge + rng.uniform(4.0, 30.0) + rng.normal(0.0, 1.2, count)
            plant_bushes(plot, rng, along, side * away, scale=(0.7, 1.8))


def _outer_verge(plot: Plot, side: int) -> float:
    """Distance of the verge's inner edge from the course, a little beyond."""
    strips = plot.site.section.strips
    outermost = strips[-1] if side > 0 else strips[0]
    inner = outermost.right if side > 0 else -outermost.left
    return abs(inner) + 0.6


def _path(plot: Plot, left: float) -> Floats:
    along = np.arange(plot.start, plot.end, 4.0)
    poses = plot.site.course.poses(along, left)
    height = plot.site.ground.height(poses[:, 0], poses[:, 1]) + plot.site.section.height(left)
    return np.column_stack([poses[:, :2], height])


def _rail(plot: Plot, left: float, *, traffic_on_left: bool) -> None:
    path = _path(plot, left)
    rail = guard_rail(path if traffic_on_left else path[::-1], sunk_ends=False)
    plot.add(rail, Surface.FURNITURE, (0.0, 0.0), np.inf)


def _bridge(plot: Plot, rng: np.random.Generator) -> None:
    """A road on a bridge across."""
    right, left = plot.site.section.edges
    opening = left - right + 3.0
    mesh = overpass(
        opening + 36.0,
        float(rng.uniform(8.0, 13.0)),
        float(rng.uniform(4.9, 6.0)),
        opening=opening,
    )
    _across(plot, mesh, float(rng.uniform(35.0, 120.0)), 0.5 * (left + right), 0.5 * opening + 20.0)


def _gantry(plot: Plot, rng: np.random.Generator) -> None:
    """Direction signs over the lanes that lead along the course."""
    own = [lane for lane in plot.site.section.lanes if lane.direction > 0]
    right = min(own[0].left - 4.5, plot.site.section.carriageway[0] - 0.8)
    left = own[-1].left + 3.0
    boards = tuple(f"gantry_{int(i)}" for i in rng.permutation(3)[: max(1, len(own) - 1)])
    mesh = sign_gantry(left - right, 5.4, boards)
    _across(plot, mesh, float(rng.uniform(40.0, 110.0)), 0.5 * (left + right), left - right)


def _across(plot: Plot, mesh: Mesh, along: float, left: float, reach: float) -> None:
    x, y, heading = plot.site.course.poses(along, left).tolist()
    height = float(plot.site.ground.height(x, y))
    low, high = mesh.bounds
    length, width, _ = (high - low + 2.0 * _CROWNS).tolist()
    plot.reserve(rectangle_polygons(np.array([x, y, heading]), length, width).item())
    plot.add(mesh.placed(x, y, height, heading), Surface.BUILDING, (x, y), reach)
