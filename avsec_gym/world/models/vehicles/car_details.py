"""What makes a body a car: lamps, grille, plates, mirrors, mouldings, rails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.block import blob, block
from avsec_gym.world.models.vehicles.body_design import CarDesign
from avsec_gym.world.models.vehicles.car_body import CarBody
from avsec_gym.world.models.vehicles.hull import column_at, on_side, patch
from avsec_gym.world.models.vehicles.lower_body import shoulder_height
from avsec_gym.world.models.vehicles.paint import CHROME, MIRROR_GLASS, PLASTIC, STEEL, Finish
from avsec_gym.world.models.vehicles.plate import number_plate
from avsec_gym.world.shapes import tube

INTAKE = Material(tint=(0.012, 0.012, 0.013), infrared=0.1)
_WIDEST = 3
"""Row of the skin along which widths are measured: where the bumpers are."""
_ROUNDED = np.array([0.72, 0.94, 1.0, 1.0, 0.96, 0.80])
"""Height of a lamp from one end to the other, share of its greatest."""


def car_details(
    rng: np.random.Generator, design: CarDesign, finish: Finish, body: CarBody
) -> list[Mesh]:
    """Everything on a car's skin, the wheels excepted."""
    return [
        *_front(rng, design, finish, body),
        *_rear(rng, design, finish, body),
        *_sides(rng, design, finish, body),
        *_on_roof(rng, design, body),
    ]


def _both(mesh: Mesh) -> list[Mesh]:
    return [mesh, mesh.mirrored()]


def _front(
    rng: np.random.Generator, design: CarDesign, finish: Finish, body: CarBody
) -> list[Mesh]:
    left, half, sill, nose = body.lower, design.half_width, design.sill, design.nose
    shape, air = design.body.headlamp, design.body.grille
    # The headlamps follow the bonnet's edge round the corner.
    outer = half + shape.wrap
    columns = column_at(left, _WIDEST, np.linspace(outer, shape.inner * half, 6), front=True)
    edge = on_side(left, columns, np.full(6, np.inf))[:, 2]
    high = left[-1, -1, 2] + 0.75 * (edge - nose) - 0.045
    swept = 1.0 - shape.sweep * np.linspace(0.0, 1.0, 6)[::-1] * 0.5
    low = high - shape.tall * _ROUNDED * swept[::-1]
    lamp = Material(f"headlamp/{shape.look}", mirror=0.10, infrared=0.6)
    parts = _both(patch(left, columns, low, high, lamp, rows=5, uv_size=(1.0, 1.0)))
    lamp_low = float(low.min())
    # Between them the grille, a chrome edge over it, and the maker's badge.
    columns = column_at(left, _WIDEST, np.linspace(air.width * half, 0.0, 5), front=True)
    top = nose - 0.05
    grille = Material(f"grille/{air.look}", infrared=0.15)
    narrow = top - air.tall * np.array([0.75, 0.95, 1.0, 1.0, 1.0])
    parts += _both(patch(left, columns, narrow, top, grille, uv_size=(0.5, 1.0)))
    middle = on_side(left, len(left) - 1, top - 0.5 * air.tall)
    badge = blob(0.02, 0.085, 0.085, CHROME)
    parts.append(badge.placed(float(middle[0]) + 0.015, 0.0, float(middle[2])))
    # Below the bumper the intake between two lamps for fog.
    columns = column_at(left, 1, np.linspace(air.intake * half, 0.0, 6), front=True)
    tall = 0.10 if design.body.rake > 0.1 else 0.07
    parts += _both(patch(left, columns, sill + 0.09, sill + 0.09 + tall, INTAKE))
    if rng.random() < 0.6 and air.intake < 0.85:
        ends = np.array([air.intake + 0.16, air.intake + 0.04]) * half
        columns = column_at(left, 1, ends, front=True)
        fog = Material("headlamp/6", mirror=0.08, infrared=0.5)
        parts += _both(
            patch(left, columns, sill + 0.09, sill + 0.16, fog, lifted=0.015, uv_size=(1.0, 1.0))
        )
    parts += _moulding(finish, body, design, front=True)
    plate_z = float(np.clip(0.5 * (sill + 0.24 + lamp_low), sill + 0.24, nose - 0.28))
    ahead = float(on_side(left, [len(left) - 1] * 2, [plate_z - 0.05, plate_z + 0.05])[:, 0].max())
    parts.append(number_plate(finish.plate, ahead + 0.02, plate_z, front=True))
    return parts


def _moulding(finish: Finish, body: CarBody, design: CarDesign, *, front: bool) -> list[Mesh]:
    """A black strip round the bumper."""
    if finish.bumper is PLASTIC or finish.strip is not PLASTIC:
        return []
    axle = design.front_axle if front else design.rear_axle
    end = 0.5 * design.length - abs(axle)
    far = design.half_width + max(end - design.wheel - 0.17, 0.1)
    columns = column_at(body.lower, _WIDEST, np.linspace(far, 0.0, 8), front=front)
    high = design.sill + (0.33 if design.height < 2.2 else 0.38)
    places = columns if front else columns[::-1]
    return _both(patch(body.lower, places, high - 0.055, high, PLASTIC, rows=2))


def _rear(rng: np.random.Generator, design: CarDesign, finish: Finish, body: CarBody) -> list[Mesh]:
    left, half, sill = body.lower, design.half_width, design.sill
    shape = design.body.tail_lamp
    red = Material(f"tail_lamp/{shape.look}", mirror=0.08, infrared=0.6)
    if rng.random() < 0.15:
        red = replace(red, glow=0.5)
    outer = half + shape.wrap
    columns = column_at(left, _WIDEST, np.linspace(shape.inner * half, outer, 6), front=False)
    high = design.belt - 0.05 - shape.sweep * shape.tall * 0.4 * np.linspace(1.0, 0.0, 6)
    tall = np.clip(shape.tall, 0.0, 0.62 * (design.belt - sill))
    low = high - tall * _ROUNDED[::-1]
    parts = _both(patch(left, columns, low, high, red, rows=4, uv_size=(1.0, 1.0)))
    parts += _moulding(finish, body, design, front=False)
    low_plate = design.body.kind in ("coupé", "roadster") or design.height > 2.1
    plate_z = sill + 0.30 if low_plate else max(float(high.max()) - 0.20, sill + 0.42)
    behind = float(on_side(left, [0, 0], [plate_z - 0.05, plate_z + 0.05])[:, 0].min())
    # A dark recess with a bar of chrome or paint above the plate.
    columns = column_at(left, _WIDEST, np.linspace(0.0, 0.33, 4), front=False)
    recess = patch(left, columns, plate_z - 0.08, plate_z + 0.085, _recess(finish), lifted=0.006)
    bar = CHROME if rng.random() < 0.35 else finish.paint
    parts += [*_both(recess), *_both(patch(left, columns, plate_z + 0.075, plate_z + 0.1, bar))]
    parts.append(number_plate(finish.plate, behind - 0.022, plate_z, front=False))
    # The shut line under the tailgate, a black apron, and the exhaust.
    columns = column_at(left, _WIDEST, np.linspace(0.0, 0.90 * half, 4), front=False)
    gap = sill + 0.35
    parts += _both(patch(left, columns, gap, gap + 0.014, INTAKE, lifted=0.006, rows=2))
    columns = column_at(left, 1, np.linspace(0.0, 0.75 * half, 4), front=False)
    parts += _both(patch(left, columns, sill + 0.06, sill + 0.13, PLASTIC, lifted=0.006))
    pipe_x = float(left[0, 0, 0]) + 0.03
    pipe = tube([(pipe_x + 0.2, 0, 0), (pipe_x - 0.05, 0, 0)], 0.03, STEEL, sides=8)
    parts.append(pipe.placed(0.0, float(rng.choice([-0.6, 0.6])) * half, sill + 0.035))
    return parts


def _recess(finish: Finish) -> Material:
    """The paint in the shade of the bar above a number plate."""
    red, green, blue = finish.paint.tint
    return replace(finish.paint, tint=(0.5 * red, 0.5 * green, 0.5 * blue))


def _sides(
    rng: np.random.Generator, design: CarDesign, finish: Finish, body: CarBody
) -> list[Mesh]:
    parts = _sign(rng, design, body)
    x = design.bonnet - 0.46
    base = float(shoulder_height(design, np.array([x]))[0])
    inside = design.half_width - 0.085
    outside = design.half_width + 0.045
    tall = 0.16 if design.height < 2.1 else 0.30
    depth = 0.075
    shell = PLASTIC if rng.random() < 0.15 or finish.bumper is PLASTIC else finish.paint
    middle = 0.5 * (inside + outside) + 0.02
    mirror = blob(2.0 * depth, 2.0 * (outside - middle), tall, shell)
    mirror = mirror.placed(x, middle, base + 0.55 * tall)
    glass = block(0.004, 1.35 * (outside - middle), 0.62 * tall, MIRROR_GLASS)
    parts += _both(mirror)
    parts += _both(glass.placed(x - depth - 0.002, middle, base + 0.24 * tall))
    foot = block(0.06, 0.10, 0.035, PLASTIC)
    parts += _both(foot.placed(x + 0.01, inside - 0.015, base + 0.05))
    radius = design.wheel + 0.1
    at = np.linspace(design.rear_axle + radius, design.front_axle - radius, 8)
    line = body.lower[:, _WIDEST, 0]
    columns = np.interp(at, line, np.arange(len(line)))
    if finish.strip is PLASTIC and rng.random() < 0.5:
        z = design.sill + 0.42 * (base - design.sill)
        parts += _both(patch(body.lower, columns, z, z + 0.05, PLASTIC, rows=2))
    if design.body.kind in ("off-roader", "pick-up") or rng.random() < 0.25:
        sills = patch(body.lower, columns, design.sill + 0.005, design.sill + 0.08, PLASTIC)
        parts += _both(sills)
    return parts


def _sign(rng: np.random.Generator, design: CarDesign, body: CarBody) -> list[Mesh]:
    """A firm's name on the flank of a delivery van."""
    if design.body.kind not in ("large van", "panel van", "delivery car") or rng.random() < 0.4:
        return []
    radius = design.wheel + 0.12
    at = np.linspace(design.rear_axle + radius, design.front_axle - radius - 0.5, 4)
    line = body.lower[:, _WIDEST, 0]
    columns = np.interp(at, line, np.arange(len(line)))
    low = design.sill + 0.42 * (design.belt - design.sill)
    name = Material(f"van_sign/{int(rng.integers(6))}", mirror=0.04, infrared=0.5)
    left = patch(body.lower, columns, low, design.belt - 0.10, name, rows=3, uv_size=(1.0, 1.0))
    # The letters run from the rear to the front on the right side.
    right = left.mirrored()
    return [left, replace(right, uv=(right.uv * [-1.0, 1.0] + [1.0, 0.0]).astype(np.float32))]


def _on_roof(rng: np.random.Generator, design: CarDesign, body: CarBody) -> list[Mesh]:
    if design.height < 1.6 and rng.random() < 0.02:
        return [_roof_box(design)]
    if rng.random() >= design.body.rails:
        return [_aerial(design)] if design.body.kind != "roadster" else []
    x = np.linspace(design.roof_rear + 0.05, design.roof_front - 0.15, 8)
    edge = body.upper[:, -1]
    order = np.argsort(edge[:, 0])
    lifted = np.array([0.0, 0.04, 0.05, 0.05, 0.05, 0.05, 0.04, 0.0])
    z = np.interp(x, edge[order, 0], edge[order, 2]) + lifted
    y = np.interp(x, edge[order, 0], edge[order, 1]) - 0.01
    material = PLASTIC if rng.random() < 0.6 else STEEL
    return _both(tube(np.column_stack([x, y, z]), 0.015, material, sides=6))


def _aerial(design: CarDesign) -> Mesh:
    """A short rod at the roof's rear edge, kept below the roof's highest line."""
    foot = (design.roof_rear + 0.16, 0.0, design.height - 0.10 - design.body.roof_drop)
    tip = (design.roof_rear - 0.02, 0.0, design.height - 0.005)
    return tube([foot, tip], 0.006, PLASTIC, sides=4)


def _roof_box(design: CarDesign) -> Mesh:
    """A luggage box; it stands above the body, which shrinks to leave room for it."""
    middle = 0.5 * (design.roof_front + design.roof_rear)
    case = blob(1.05 * (design.roof_front - design.roof_rear), 0.8, 0.36, PLASTIC)
    return case.placed(middle, 0.15 * design.half_width, design.height - 0.04)
