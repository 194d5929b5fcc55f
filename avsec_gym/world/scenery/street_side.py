"""Lamps, signs, bins, bicycles: what lines a street at regular or odd places."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial

import numpy as np

from avsec_gym.world.assets import Assets, seed_of
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.furniture.catalogue import FURNITURE
from avsec_gym.world.models.people import make_bicycle
from avsec_gym.world.scenery.plot import Plot
from avsec_gym.world.section import Surface

GROUPS = {
    "street_sign": (
        "sign_speed_30",
        "sign_zone_30",
        "sign_no_entry",
        "sign_no_stopping",
        "sign_no_parking",
        "sign_parking",
        "sign_crossing",
        "sign_priority_road",
        "sign_give_way",
        "sign_one_way",
        "sign_residents",
        "sign_footpath",
        "sign_children",
        "sign_bus_stop",
    ),
    "country_sign": (
        "sign_speed_70",
        "sign_speed_100",
        "sign_bend",
        "sign_no_overtaking",
        "sign_priority_road",
        "sign_direction",
    ),
    "highway_sign": ("sign_speed_100", "sign_speed_120", "sign_no_overtaking", "sign_exit"),
    "bollard": ("bollard_iron", "bollard_steel", "bollard_banded", "bollard_stone"),
    "bin": ("wheelie_bin", "bin_row"),
    "poster": ("poster_stand", "pavement_board", "poster_on_pole", "advertising_pillar"),
    "cafe": ("cafe_table", "parasol", "parasol_closed", "flower_box", "planter"),
    "works": ("site_barrier", "warning_beacon", "traffic_cone", "site_fence"),
}
"""Names that stand for one of several things."""
_BICYCLES = 24
"""Parked ones that look different."""
_TOWARDS_ROAD = ("bench", "bench_block", "post_box", "junction_box", "bicycle_stand", "bus_shelter")


def make(name: str, rng: np.random.Generator, part: Assets) -> Mesh:
    """A thing of the catalogue, or one of a group, of a part of the assets."""
    names = GROUPS.get(name, (name,))
    return FURNITURE[names[int(rng.integers(len(names)))]](rng, part)


def heading_beside(side: int) -> float:
    """Of things beside the road: they face the traffic that passes, arms reach over the road."""
    return 0.0 if side < 0 else np.pi


def line_up(
    plot: Plot,
    rng: np.random.Generator,
    name: str,
    left: float,
    spacing: float,
    *,
    missing: float = 0.1,
    on_road: bool = True,
) -> None:
    """One thing at even distances along the road: lamps, bollards, posts.

    Args:
        plot: The plot that is furnished.
        rng: The source of chance.
        name: A name in `FURNITURE` or `GROUPS`.
        left: Offset from the course, metres.
        spacing: Distance between neighbours, metres.
        missing: Share left out.
        on_road: Whether they stand on the pavement or verge.
    """
    mesh, heading = make(name, rng, plot.part), heading_beside(1 if left > 0 else -1)
    for along in np.arange(plot.start + float(rng.uniform(0, spacing)), plot.end, spacing):
        if rng.random() < missing:
            continue
        at = float(along + rng.normal(0.0, 0.03 * spacing))
        plot.place(
            mesh, Surface.FURNITURE, at, left, heading=heading, size=(0.3, 0.3), on_road=on_road
        )


def scatter(
    plot: Plot,
    rng: np.random.Generator,
    things: Mapping[str, float],
    side: int,
    nearest: float,
    farthest: float,
) -> None:
    """Things at odd places in the strip between two distances from the course.

    Args:
        plot: The plot that is furnished.
        rng: The source of chance.
        things: Names in `FURNITURE` or `GROUPS` (or ``bicycle``), and the average number of each in
            100 m.
        side: Side of the course: 1 left, -1 right.
        nearest: Least distance from the course, metres.
        farthest: Largest distance from the course, metres.
    """
    for name, density in things.items():
        count = int(rng.poisson(density * (plot.end - plot.start) / 100.0))
        for _ in range(count):
            along = float(rng.uniform(plot.start, plot.end))
            left = side * float(rng.uniform(nearest, max(farthest, nearest + 0.1)))
            if name == "bicycle":
                _bicycles(plot, rng, along, left, side)
                continue
            turn = float(rng.normal(0.0, 0.06))
            turn += 0.5 * np.pi * side if name in _TOWARDS_ROAD else heading_beside(side)
            mesh = make(name, rng, plot.part)
            low, high = mesh.bounds
            at_foot = mesh.vertices[:, 2] < 0.5
            extent = (
                np.ptp(mesh.vertices[at_foot, :2], axis=0) if at_foot.any() else (high - low)[:2]
            )
            plot.place(
                mesh,
                Surface.FURNITURE,
                along,
                left,
                heading=turn,
                size=(float(extent[0]) + 0.1, float(extent[1]) + 0.1),
                on_road=True,
            )


def _bicycles(plot: Plot, rng: np.random.Generator, along: float, left: float, side: int) -> None:
    """A few parked side by side."""
    heading = float(rng.choice([0.0, 0.5 * np.pi])) + float(rng.normal(0.0, 0.1))
    across = abs(np.sin(heading)) > 0.5
    for index in range(int(rng.integers(1, 5))):
        bicycle = partial(_bicycle, seed_of(plot.part, int(rng.integers(_BICYCLES))))
        step = 0.65 * index
        plot.place(
            bicycle,
            Surface.FURNITURE,
            along + (step if across else 0.0),
            left + (0.0 if across else side * step),
            heading=heading + float(rng.normal(0.0, 0.05)),
            size=(1.75, 0.5),
            on_road=True,
        )


def _bicycle(appearance: int, distance: float) -> Mesh:
    return _bicycles_by_look(appearance)


_bicycles_by_look = cache(make_bicycle)
