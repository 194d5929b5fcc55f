"""All street furniture by name."""

from __future__ import annotations

from avsec_gym.world.models.furniture import (
    advertising,
    bins,
    bus_shelter,
    cafe,
    lamps,
    pavement,
    poles,
    roadside,
    traffic_lights,
    traffic_signs,
)
from avsec_gym.world.models.furniture.variants import Model

_MODELS: tuple[Model, ...] = (
    lamps.lamp_mast,
    lamps.lamp_post_top,
    lamps.lamp_globe,
    lamps.lamp_lantern,
    traffic_lights.traffic_light,
    roadside.delineator,
    roadside.bollard_iron,
    roadside.bollard_steel,
    roadside.bollard_banded,
    roadside.bollard_stone,
    roadside.traffic_cone,
    roadside.site_barrier,
    roadside.warning_beacon,
    roadside.site_fence,
    bins.wheelie_bin,
    bins.bin_row,
    bins.litter_bin,
    pavement.bench,
    pavement.bench_block,
    pavement.post_box,
    pavement.bicycle_stand,
    pavement.junction_box,
    advertising.advertising_pillar,
    advertising.poster_stand,
    advertising.pavement_board,
    advertising.poster_on_pole,
    advertising.billboard,
    bus_shelter.bus_shelter,
    cafe.cafe_table,
    cafe.parasol,
    cafe.parasol_closed,
    cafe.planter,
    cafe.flower_box,
    poles.flag_pole,
    poles.telephone_mast,
)

FURNITURE: dict[str, Model] = {
    **{model.__name__: model for model in _MODELS},
    **traffic_signs.SIGNS,
}
"""What stands on one spot; see `barriers`, `fences` and `crossings` for what is long."""
