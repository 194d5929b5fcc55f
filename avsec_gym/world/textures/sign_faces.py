"""German traffic signs: their sizes, outlines and faces."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from avsec_gym.world.textures import sign_symbols as symbols
from avsec_gym.world.textures.drawing import Canvas, Colour, canvas, fill, finished
from avsec_gym.world.textures.sign_symbols import (
    BLACK,
    BLUE,
    GREEN,
    RED,
    WHITE,
    YELLOW,
    outline,
    shrunk,
)
from avsec_gym.world.textures.texture import Picture, Texture

_RIM: Colour = (150, 154, 156)
"""Bare aluminium round the edge."""


class SignFace(NamedTuple):
    """A sign as it is made."""

    outline: str
    """A name for `outline`."""
    width: float
    """Metres."""
    height: float
    paint: Callable[[Canvas], None]
    """Draws all but the rim and the ground."""
    ground: Colour = WHITE
    edge: Colour = WHITE
    """A narrow line along the outline."""


def sign_texture(face: SignFace) -> Texture:
    """The texture of one sign; it shows the sign once, upright."""

    def make(_: int, rng: np.random.Generator) -> Picture:
        density = min(230.0, 480.0 / face.width)
        on = canvas(face.width, face.height, _RIM, density)
        corners = outline(face.outline, face.width, face.height)
        line = 0.03 * min(1.0, face.height / 0.5)
        for inset, colour in ((0.4 * line, face.edge), (line, face.ground)):
            fill(on, shrunk(corners, inset), colour)
        face.paint(on)
        return finished(on, rng)

    return Texture((face.width, face.height), 1, make)


def _round(paint: Callable[[Canvas], None], ground: Colour = WHITE) -> SignFace:
    return SignFace("disc", 0.6, 0.6, paint, ground)


def _square(paint: Callable[[Canvas], None], ground: Colour = BLUE, side: float = 0.6) -> SignFace:
    return SignFace("rectangle", side, side, paint, ground)


STREET_NAMES = ("Hauptstraße", "Lindenweg", "Goethestraße", "Rheinstraße", "Mühlweg", "Gartenweg")

SIGN_FACES: dict[str, SignFace] = {
    **{
        f"speed_{limit}": _round(partial(symbols.speed_limit, limit))
        for limit in ("30", "50", "70", "100", "120")
    },
    "zone_30": _square(symbols.zone_30, WHITE, 0.84),
    "no_entry": _round(symbols.no_entry, RED),
    "keep_right": _round(symbols.keep_right, BLUE),
    "straight_or_right": _round(symbols.straight_or_right, BLUE),
    "stop": SignFace("octagon", 0.9, 0.9, symbols.stop, RED),
    "give_way": SignFace("give_way", 0.9, 0.78, symbols.give_way, RED),
    "priority_road": SignFace("diamond", 0.84, 0.84, symbols.priority_road),
    "no_stopping": _round(partial(symbols.no_stopping, True)),
    "no_parking": _round(partial(symbols.no_stopping, False)),
    "no_turning_back": _round(symbols.no_turning_back),
    "no_overtaking": _round(symbols.no_overtaking),
    "no_vehicles": _round(symbols.no_vehicles),
    "footpath": _round(symbols.footpath, BLUE),
    "parking": _square(symbols.parking),
    "crossing": _square(symbols.pedestrian_crossing),
    "dead_end": _square(symbols.dead_end),
    "play_street": SignFace("rectangle", 0.9, 0.6, symbols.play_street, BLUE),
    "one_way": SignFace("rectangle", 0.8, 0.3, symbols.one_way, BLUE),
    "bus_stop": SignFace("disc", 0.45, 0.45, symbols.bus_stop, GREEN, YELLOW),
    "children": SignFace("triangle", 0.9, 0.78, partial(symbols.warning, "children"), RED),
    "bend": SignFace("triangle", 0.9, 0.78, partial(symbols.warning, "bend"), RED),
    "priority": SignFace("triangle", 0.9, 0.78, partial(symbols.warning, "priority"), RED),
    "bend_arrows": SignFace("rectangle", 2.0, 0.5, symbols.bend_arrows),
    "residents": SignFace("rectangle", 0.6, 0.33, symbols.residents, WHITE, BLACK),
    **{
        f"street_name_{index}": SignFace(
            "rectangle", 0.8, 0.16, partial(symbols.street_name, name), BLUE
        )
        for index, name in enumerate(STREET_NAMES)
    },
    **{
        f"town_{index}": SignFace(
            "rectangle", 1.0, 0.65, partial(symbols.town_entrance, *names), YELLOW, BLACK
        )
        for index, names in enumerate(
            (
                ("Durlach", "Stadt Karlsruhe"),
                ("Ettlingen", "Landkreis Karlsruhe"),
                ("Rastatt", "Baden"),
            )
        )
    },
    **{
        f"direction_{index}": SignFace(
            "rectangle", 1.5, 0.35, partial(symbols.direction_board, *names), YELLOW, BLACK
        )
        for index, names in enumerate((("Ettlingen", "7"), ("Bruchsal", "21"), ("Pforzheim", "26")))
    },
    **{
        f"gantry_{index}": SignFace(
            "rectangle", 6.4, 2.6, partial(symbols.gantry_board, names), BLUE
        )
        for index, names in enumerate(
            (
                (("Stuttgart", "Pforzheim"), ("Basel", "Ettlingen")),
                (("Frankfurt", "Heidelberg"), ("Karlsruhe", "Durlach")),
                (("Heilbronn", "Bretten"), ("Mannheim", "Bruchsal")),
            )
        )
    },
    "exit": SignFace("rectangle", 2.2, 0.6, symbols.motorway_exit, BLUE),
}
"""Sign faces by name; the texture of one is called ``sign_<name>``."""
