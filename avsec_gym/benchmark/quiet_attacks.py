"""What an attacker tries who knows a validator: weaker or smaller light than the listed attack's.

He asks the car, and its validator, as black boxes: each attempt takes a query, and he keeps the one
under which most episodes collide without an alarm.  No attempt has more light, a wider spot or a
larger bogus object than the attack that is listed; the first attempt is that attack itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

_COLUMNS, _ROW = (250.0, 450.0, 620.0, 790.0, 990.0), 190.0
"""Pixels of an image of 1242 x 375: where road users stand, at the height of the horizon."""
_RADII, _STRENGTHS = (30.0, 90.0), (255.0, 128.0)
"""Pixels, grey levels; the listed facula has a radius of 187 or more and a strength of 255."""
_DISTANCES, _WIDTHS = ((6.0, 10.0), (10.0, 20.0), (20.0, 30.0)), (2.5, 1.2)
"""Metres; the listed bogus plane stands at 6 to 10 m and is 2.5 m wide."""

QUIETER: Mapping[str, Sequence[Any]] = {
    "facula": [
        {
            "name": "facula",
            "camera": 2,
            "centre": [column, _ROW],
            "radius": radius,
            "strength": strength,
        }
        for column, radius, strength in product(_COLUMNS, _RADII, _STRENGTHS)
    ],
    "lidar_spoofing": [
        {"name": "lidar_spoofing", "distance": [*distance], "width": width, "rays_lost": lost}
        for distance, width, lost in product(_DISTANCES, _WIDTHS, (False, True))
    ],
}
"""Attempts by the validator's case, after the listed attack."""
INSTANT_TRIES = 8
"""Attempts on each instant of connected vehicles; the first is the listed attack."""
