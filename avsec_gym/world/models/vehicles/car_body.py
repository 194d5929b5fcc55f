"""Bodies of cars and vans: a lower skin with wheel arches, and a greenhouse of windows on it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.block import block
from avsec_gym.world.models.vehicles.designs import CarDesign
from avsec_gym.world.models.vehicles.hull import Floats, Outline, Skin, outline, skin
from avsec_gym.world.models.vehicles.paint import BLACK_GLOSS, PLASTIC, SEAT, UNDERSIDE, Finish

ARCH_GAP = 0.055
"""Between tyre and wheel arch, metres."""

_LIP = 0.045
# Rows of the lower skin from the floor to the shoulder: how far inside the widest line they are,
# how far behind the foremost one, and before the rearmost one; metres.
_INSET = np.array([0.27, 0.27, 0.045, 0.022, 0.0, 0.006, 0.026, 0.044, 0.095])
_FRONT = np.array([0.30, 0.30, 0.11, 0.055, 0.0, 0.012, 0.05, 0.09, 0.19])
_REAR = np.array([0.30, 0.30, 0.11, 0.055, 0.0, 0.035, 0.065, 0.08, 0.115])
_ACROSS = (0.10, 0.5, 0.90)


class CarBody(NamedTuple):
    """A car's surfaces, and the skins on which its lamps and plates are placed."""

    parts: list[Mesh]
    lower: Floats
    """Left side from lip to shoulder, shape (K, 7, 3)."""
    upper: Floats
    """Left side of the greenhouse, shape (K, 6, 3)."""


def car_body(design: CarDesign, finish: Finish) -> CarBody:
    """Skin, windows and a dark underside, without wheels and lamps."""
    lower = _lower_skin(design)
    plan, upper = _greenhouse(design)
    parts = [*_lower_panels(design, finish, lower), *_upper_panels(design, finish, plan, upper)]
    parts += _seats(design)
    return CarBody(parts, lower.left[:, 2:], upper.left)


def shoulder_height(design: CarDesign, x: Floats) -> Floats:
    """Where the lower skin ends: bonnet, belt line and boot, at places along the car."""
    front = 0.5 * design.length
    rise = design.cowl - design.nose
    ahead = front - design.bonnet
    return np.interp(
        x,
        [-front, design.boot, design.bonnet, front - 0.55 * ahead, front - 0.2 * ahead, front],
        [
            design.belt - 0.01,
            design.belt,
            design.cowl,
            design.nose + 0.74 * rise,
            design.nose + 0.38 * rise,
            design.nose,
        ],
    )


def _lower_skin(design: CarDesign) -> Skin:
    front = 0.5 * design.length
    radius = design.wheel + ARCH_GAP
    arch = radius * np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, 7))
    arch = np.concatenate([[-radius - 0.02], arch, [radius + 0.02]])
    between = np.linspace(design.rear_axle + radius, design.front_axle - radius, 4)[1:-1]
    stations = np.concatenate([design.rear_axle + arch, between, design.front_axle + arch])
    body = design.body
    plan = outline(
        -front, front, 0.6 * body.roundness, body.roundness, stations, squareness=body.squareness
    )
    top = shoulder_height(design, plan.x)
    beyond = (plan.x > design.front_axle) + 1.3 * (plan.x < design.rear_axle)
    bottom = np.maximum(
        design.sill + 0.045 * beyond,
        np.maximum(
            *(
                _arch_height(plan.x - axle, radius, design.wheel)
                for axle in (design.rear_axle, design.front_axle)
            )
        ),
    )
    start = design.sill + _LIP
    shares = np.array([0.0, 0.36, 0.68, 1.0])
    flank = start + shares * (top[:, None] - 0.11 - start)
    flank = np.maximum(flank, bottom[:, None] + _LIP + 0.02 * np.arange(4))
    inner = np.full_like(bottom, design.sill + 0.02)
    z = np.column_stack([np.minimum(inner, bottom), bottom, bottom, flank, top - 0.04, top])
    upright = float(np.clip(body.tailgate / 0.3, 0.4, 1.0))
    left = _bent(plan, design.half_width, _INSET, _FRONT, upright * _REAR, z)
    return skin(left, _ACROSS, 0.055)


def _bent(
    plan: Outline, half_width: float, inset: Floats, front: Floats, rear: Floats, z: Floats
) -> Floats:
    """Left side of a lower skin, shape (K, J, 3): barrel-shaped in plan, its ends by row."""
    middle = 0.5 * (plan.x[0] + plan.x[-1])
    barrel = 1.0 - 0.03 * ((plan.x - middle) / (plan.x[-1] - middle)) ** 2
    x = plan.x[:, None] - plan.front[:, None] * front + plan.rear[:, None] * rear
    y = (half_width * barrel[:, None] - inset) * plan.y[:, None]
    return np.stack([x, y, z], axis=-1)


def _arch_height(offset: Floats, radius: float, centre: float) -> Floats:
    inside = radius**2 - offset**2
    return np.where(inside > -1e-6, centre + np.sqrt(np.maximum(inside, 0.0)), 0.0)


def _lower_panels(design: CarDesign, finish: Finish, lower: Skin) -> list[Mesh]:
    every = slice(None)
    count = lower.points.shape[1]
    uv = _flank_uv(design, lower)
    parts = [
        lower.panel(UNDERSIDE, every, slice(0, 3)),
        lower.panel(UNDERSIDE, every, slice(count - 3, count)),
    ]
    radius = design.wheel + ARCH_GAP
    behind = int((lower.points[:, 9, 0] < design.rear_axle - radius).sum())
    ahead = int((lower.points[:, 9, 0] <= design.front_axle + radius).sum())
    for columns, material in (
        (slice(0, behind + 1), finish.bumper),
        (slice(behind, ahead), finish.flank),
        (slice(ahead - 1, None), finish.bumper),
    ):
        # Bumpers of black plastic reach up to the second row above the lip.
        whole = material is not PLASTIC
        for low, high in ((2, 9),) if whole else ((2, 5), (4, 9)):
            used = material if low == 2 and not whole else finish.flank
            for across in (slice(low, high), slice(count - high, count - low)):
                parts.append(lower.panel(used, columns, across, uv[columns, across]))
    # The floor closes the underside; under the greenhouse the deck is the dark inside of the car.
    floor = np.stack([lower.points[:, -1], lower.points[:, 0]], axis=1)
    down = np.zeros_like(floor)
    down[..., 2] = -1.0
    parts.append(Skin(floor, down, 1).panel(UNDERSIDE, every, every))
    middle_x = lower.points[:, 9, 0]
    inside = np.flatnonzero((middle_x > design.boot + 0.05) & (middle_x < design.bonnet - 0.1))
    first, last = int(inside[0]), int(inside[-1])
    across = slice(8, count - 8)
    parts += [
        lower.panel(finish.paint, slice(0, first + 1), across),
        lower.panel(SEAT, slice(first, last + 1), across),
        lower.panel(finish.bonnet, slice(last, None), across, _bonnet_uv(lower, last, across)),
    ]
    return parts


def _flank_uv(design: CarDesign, lower: Skin) -> Floats:
    """Where the flank lies on its texture, on which axles and pillars have fixed places."""
    front = 0.5 * design.length
    side_rear = design.boot + 0.25
    side = design.bonnet - 0.3 - side_rear
    x = lower.points[..., 0]
    pillar = side_rear + side * design.body.windows[-1][0] - 0.04
    places = np.array([-front, design.rear_axle, pillar, design.front_axle - 0.42, front])
    u = np.interp(x, places, [0.0, 0.8, 2.1, 3.1, 4.0])
    top = shoulder_height(design, x)
    v = (top - lower.points[..., 2]) / np.maximum(top - design.sill, 0.1)
    return np.stack([u, np.clip(v, 0.01, 0.99)], axis=-1)


def _bonnet_uv(lower: Skin, first: int, across: slice) -> Floats:
    """Once over the bonnet, from side to side and from the windscreen to the front."""
    points = lower.points[first:, across]
    x, y = points[..., 0], points[..., 1]
    u = 0.5 + 0.49 * y / np.maximum(np.abs(y).max(axis=1, keepdims=True), 1e-6)
    v = (x.max() - x) / np.ptp(x)
    return np.stack([u, 0.99 - 0.98 * v], axis=-1)


def _greenhouse(design: CarDesign) -> tuple[Outline, Skin]:
    body = design.body
    rear_round, front_round = 0.24, 0.34
    side = np.array([design.boot + rear_round, design.bonnet - front_round])
    edges = np.array(sorted({edge for window in body.windows for edge in window}))
    stations = side[0] + edges * (side[1] - side[0])
    plan = outline(
        design.boot,
        design.bonnet,
        rear_round,
        front_round,
        stations,
        squareness=max(2.6, body.squareness - 0.2),
    )
    pillar = side[0] + (side[1] - side[0]) * 0.5
    forward = np.clip((plan.x - pillar) / (side[1] - pillar), 0.0, 1.0)
    backward = np.clip((pillar - plan.x) / (pillar - side[0]), 0.0, 1.0)
    glass = body.glass
    level = np.tile([0.0, 0.06, 0.5 * glass + 0.05, glass, 0.985, 1.0], (len(plan.x), 1))
    level[plan.rear > 0, 1], level[plan.rear > 0, 3] = body.rear_glass
    bulge = 0.05 * np.sin(np.pi * level)
    shift = forward[:, None] * ((design.roof_front - design.bonnet) * level + bulge)
    shift += backward[:, None] * ((design.roof_rear - design.boot) * level - bulge)
    x = plan.x[:, None] + shift
    shoulder = design.half_width - 0.075
    roof = design.half_width * body.roof
    width = shoulder + (roof - shoulder) * level**1.2 + 0.3 * bulge
    width[:, -1] -= 0.06
    y = width * plan.y[:, None]
    base = shoulder_height(design, plan.x) - 0.012
    middle = 0.5 * (design.roof_front + design.roof_rear)
    half = 0.5 * (design.roof_front - design.roof_rear)
    edge = design.height - 0.045 - 0.05 * ((x[:, -1] - middle) / half) ** 2
    z = base[:, None] + level * (edge - base)[:, None]
    # The last row rounds the roof's edge off.
    z[:, -2] -= 0.022
    left = np.stack([x, y, z], axis=-1)
    left[:, -1, 0] += 0.05 * (backward * (plan.rear > 0) - forward * (plan.front > 0))
    return plan, skin(left, (0.16, 0.5, 0.84), 0.05)


def _upper_panels(design: CarDesign, finish: Finish, plan: Outline, upper: Skin) -> list[Mesh]:
    every = slice(None)
    count, last = upper.points.shape[1], len(plan.x) - 1
    parts = [
        upper.panel(finish.paint, every, slice(3, count - 3)),
    ]
    rear_edge = int(np.flatnonzero(plan.rear > 0.3)[-1])
    front_edge = int(np.flatnonzero(plan.front > 0)[0])
    side = _window_columns(design, plan)
    bands: list[tuple[int, int, Material]] = [(0, rear_edge, finish.rear_glass)]
    at = rear_edge
    for first, second in side:
        if first > at:
            pillar = finish.paint if at == rear_edge else BLACK_GLOSS
            bands.append((at, first, pillar))
        bands.append((first, second, finish.side_glass))
        at = second
    bands += [(at, front_edge, finish.paint), (front_edge, last, finish.windscreen)]
    for first, second, material in bands:
        columns = slice(first, second + 1)
        for across in (slice(1, 4), slice(count - 4, count - 1)):
            uv = _glass_uv(upper, columns, across, material)
            parts.append(upper.panel(material, columns, across, uv))
        below = finish.paint if material is finish.paint else BLACK_GLOSS
        for across in (slice(0, 2), slice(count - 2, count)):
            parts.append(upper.panel(below, columns, across))
    return parts


def _window_columns(design: CarDesign, plan: Outline) -> list[tuple[int, int]]:
    start, end = design.boot + 0.24, design.bonnet - 0.34
    at = [[start + share * (end - start) for share in window] for window in design.body.windows]
    return [
        (int(np.abs(plan.x - rear).argmin()), int(np.abs(plan.x - front).argmin()))
        for rear, front in at
    ]


def _glass_uv(upper: Skin, columns: slice, across: slice, material: Material) -> Floats:
    """Once over each window; over the whole width for the windscreen and the rear window."""
    points = upper.points[columns, across]
    z = points[..., 2]
    low, high = z.min(axis=1, keepdims=True), z.max(axis=1, keepdims=True)
    v = (high - z) / np.maximum(high - low, 1e-6)
    if material.texture.startswith("side"):
        x = points[..., 0]
        u = (x.max() - x) / max(float(np.ptp(x)), 1e-6)
    else:
        way = 1.0 if material.texture.startswith("wind") else -1.0
        u = 0.5 + way * 0.5 * points[..., 1] / np.abs(points[..., 1]).max()
    return np.stack([np.clip(u, 0.005, 0.995), np.clip(v, 0.01, 0.99)], axis=-1)


def _seats(design: CarDesign) -> list[Mesh]:
    """What LiDAR pulses meet behind the windows."""
    width, height = 1.5 * design.half_width, 0.45 * (design.height - design.belt)
    rear = design.roof_rear + 0.25 * (design.roof_front - design.roof_rear)
    rows = (design.roof_front - 0.45, rear)
    return [block(0.16, width, height, SEAT).placed(x, 0.0, design.belt - 0.05) for x in rows]
