"""What is seen, and met by LiDAR pulses, through a car's windows."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.block import block, cushion
from avsec_gym.world.models.vehicles.body_design import CarDesign
from avsec_gym.world.models.vehicles.paint import LINING, Finish
from avsec_gym.world.shapes import tube

_TWO_SEATS = ("panel van", "large van", "delivery car", "roadster")
_ROW_GAP = 0.85
"""Metres between the backs of two rows of seats."""


def interior(design: CarDesign, finish: Finish) -> list[Mesh]:
    """Seats with head rests, a dashboard and a steering wheel, above the belt line."""
    belt, room = design.belt, design.height - design.belt
    # Under the roof's front third sit the drivers; a second row as far as there is roof.
    first = design.roof_front - 0.25 - 0.12 * (design.bonnet - design.roof_front)
    end = design.roof_rear if design.body.tailgate > 0.2 else design.roof_rear + 0.3
    rows = np.arange(first, min(end, first - 0.5), -_ROW_GAP)[:2]
    if design.body.kind in _TWO_SEATS:
        rows = rows[:1]
    tall = min(0.62 * room, 0.30)
    across = 0.46 * design.half_width
    parts = []
    for number, x in enumerate(rows):
        # Rear rows are benches.
        seats = (-across, across) if number == 0 else (-1.15 * across, 0.0, 1.15 * across)
        wide = 0.46 if number == 0 else 0.40
        for y in seats:
            back = cushion(0.15, wide, 2.0 * tall, finish.seat)
            rest = cushion(0.09, 0.25, 0.15, finish.seat)
            parts += [
                back.placed(float(x), y, belt - 0.16),
                rest.placed(float(x) - 0.03, y, belt + tall - 0.06),
            ]
    deep = design.bonnet - design.roof_front
    board = block(0.45 * deep, 1.6 * design.half_width, 0.09, LINING)
    parts.append(board.placed(design.bonnet - 0.34 * deep, 0.0, design.belt - 0.03))
    angle = np.linspace(0.0, 2.0 * np.pi, 11)
    # Left-hand drive, the wheel leaning towards the driver.
    rim = np.column_stack([0.07 * np.sin(angle), 0.17 * np.cos(angle), 0.16 * np.sin(angle)])
    wheel_x = min(float(first) + 0.52, design.bonnet - 0.62 * deep)
    parts.append(tube(rim, 0.014, LINING, sides=5).placed(wheel_x, across, belt + 0.02))
    return parts
