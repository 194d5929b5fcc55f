"""Streets between houses: city, residential, campus."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.scenery.frontage import BuildingRow, build_behind, build_row, front_garden
from avsec_gym.world.scenery.planting import plant_bushes, plant_hedge, plant_trees
from avsec_gym.world.scenery.plot import Plot
from avsec_gym.world.scenery.street_side import line_up, scatter

_STREET_TREES = ("lime", "maple", "plane", "young", "birch")
_GARDEN_TREES = (
    *("birch", "fruit", "spruce", "pine", "maple", "willow", "poplar"),
    *("lime", "fruit", "birch", "maple", "lime", "spruce", "copper_beech"),
)
_PARK_TREES = ("lime", "plane", "maple", "birch", "pine", "autumn", "lime", "maple", "copper_beech")


def city(plot: Plot, manner: np.random.Generator, rng: np.random.Generator) -> None:
    """Closed rows of tall houses, street trees, signs, bicycles."""
    shops = float(manner.uniform(0.1, 0.7))
    apartments = float(manner.uniform(0.0, 0.25))
    for side in (1, -1):
        # Houses along the street and behind it, yards in the gaps.
        openness = float(manner.beta(0.8, 4.0))
        row = BuildingRow(
            kinds={
                "terrace": 1.0 - shops - 0.5 * apartments,
                "shop": shops,
                "apartment": apartments,
            },
            widths=(9.0, 19.0),
            depths=(10.0, 13.0),
            setback=(0.0, 0.2) if manner.random() < 0.75 else (2.5, 5.0),
            gap=(2.0, 12.0),
            gap_share=0.12 + 0.6 * openness,
        )
        gaps = build_row(plot, rng, row, side)
        build_behind(plot, rng, side, gaps, ("terrace", "terrace", "apartment"))
        _fill_gaps(plot, rng, side, 5.0)
        right, left = plot.site.section.edges
        edge = left if side > 0 else -right
        # Trees, lamps and signs at the kerb.
        kerb = plot.kerb(side)
        if manner.random() < 0.6:
            _avenue(plot, manner, rng, side * (kerb + float(rng.uniform(0.7, 1.2))))
        lamp = str(manner.choice(["lamp_mast", "lamp_post_top", "lamp_lantern"], p=[0.6, 0.2, 0.2]))
        line_up(plot, rng, lamp, side * (kerb + 0.5), 28.0)
        scatter(
            plot,
            rng,
            {
                "street_sign": 3.0,
                "traffic_light": 0.8,
                "sign_street_name": 0.8,
                "litter_bin": 1.0,
                "post_box": 0.3,
                "junction_box": 0.8,
                "bollard": 1.5,
                "poster": 0.7,
                "bicycle": 0.8,
            },
            side,
            kerb + 0.4,
            kerb + 0.9,
        )
        scatter(
            plot,
            rng,
            {
                "bicycle": 0.8,
                "poster": 0.8,
                "planter": 1.0,
                "cafe": 4.0 * shops,
                "bin": 1.0,
            },
            side,
            edge - 1.2,
            edge - 0.5,
        )


def residential(plot: Plot, manner: np.random.Generator, rng: np.random.Generator) -> None:
    """Detached houses behind gardens, garages, hedges, now and then a block of flats."""
    gardens = manner.random() < 0.75
    for side in (1, -1):
        row = BuildingRow(
            kinds={
                "detached": 1.0,
                "garage": 0.22,
                "apartment": 0.15,
                "terrace": 0.2 if gardens else 1.2,
            },
            widths=(8.0, 14.0),
            depths=(9.0, 12.0),
            setback=(3.0, 7.5) if gardens else (0.0, 0.6),
            gap=(2.5, 9.0),
            gap_share=0.9 if gardens else 0.35,
        )
        species = tuple(str(kind) for kind in manner.choice(_GARDEN_TREES, 4, replace=False))
        build_row(plot, rng, row, side, before=front_garden(plot, rng, side, species))
        _fill_gaps(plot, rng, side, 8.0)
        kerb = plot.kerb(side)
        edge = abs(plot.site.section.edges[1 if side > 0 else 0])
        if manner.random() < 0.22:
            _avenue(plot, manner, rng, side * (kerb + 0.8))
        if side > 0 or manner.random() < 0.3:
            line_up(plot, rng, "lamp_mast", side * (edge - 0.3), 33.0)
        scatter(
            plot,
            rng,
            {
                "street_sign": 1.4,
                "sign_street_name": 0.5,
                "junction_box": 0.8,
                "bin": 2.5,
                "bicycle": 0.3,
                "telephone_mast": 0.3,
            },
            side,
            edge - 0.6,
            edge - 0.2,
        )


def campus(plot: Plot, manner: np.random.Generator, rng: np.random.Generator) -> None:
    """Large buildings on lawns, old trees, bicycles everywhere."""
    for side in (1, -1):
        # Buildings, or a wood.
        edge = abs(plot.site.section.edges[1 if side > 0 else 0])
        wooded = manner.random() < 0.35
        if not wooded:
            row = BuildingRow(
                kinds={"campus": 1.0, "hall": 0.2, "apartment": 0.2},
                widths=(22.0, 45.0),
                depths=(12.0, 18.0),
                setback=(4.0, 16.0),
                gap=(8.0, 25.0),
            )
            build_row(plot, rng, row, side)
        # Trees, bushes, now and then a hedge.
        count = int(rng.integers(25, 60) if wooded else rng.integers(8, 24))
        along = rng.uniform(plot.start, plot.end, count)
        away = edge + 1.5 + (34.0 if wooded else 18.0) * rng.random(count)
        plant_trees(plot, rng, _PARK_TREES, along, side * away)
        bushes = int(rng.integers(8, 40))
        along = rng.uniform(plot.start, plot.end, bushes)
        plant_bushes(plot, rng, along, side * (edge + 1.0 + 14.0 * rng.random(bushes)))
        if manner.random() < 0.4:
            length = float(rng.uniform(8.0, 20.0))
            plant_hedge(plot, rng, float(rng.uniform(5, 60)), side * (edge + 1.2), length, 1.4)
        # Lamps and furniture along the paths.
        line_up(plot, rng, "lamp_globe", side * (edge + 0.6), 22.0, on_road=False)
        scatter(
            plot,
            rng,
            {
                "bicycle": 2.5,
                "bench": 2.5,
                "litter_bin": 1.5,
                "bollard": 2.0,
                "street_sign": 0.8,
                "bicycle_stand": 1.5,
                "poster": 0.8,
                "flag_pole": 0.4,
            },
            side,
            edge - 0.5,
            edge + 4.0,
        )


def _avenue(plot: Plot, manner: np.random.Generator, rng: np.random.Generator, left: float) -> None:
    """Trees of one kind at even distances in the pavement."""
    kind = str(manner.choice(_STREET_TREES))
    spacing = float(manner.uniform(8.0, 16.0))
    along = np.arange(plot.start + float(rng.uniform(0, spacing)), plot.end, spacing)
    along = along[rng.random(len(along)) < 0.9]
    plant_trees(
        plot, rng, (kind,), along, np.full(len(along), left), on_road=True, scale=(0.7, 1.1)
    )


def _fill_gaps(plot: Plot, rng: np.random.Generator, side: int, density: float) -> None:
    """Trees and sheds in yards and behind the houses, so that gaps do not look into a void."""
    edge = abs(plot.site.section.edges[1 if side > 0 else 0])
    count = int(rng.poisson(density * (plot.end - plot.start) / 100.0))
    along = rng.uniform(plot.start, plot.end, count)
    plant_trees(plot, rng, _GARDEN_TREES, along, side * (edge + rng.uniform(8.0, 40.0, count)))
