"""What makes a body a car: lamps, grille, plates, mirrors, mouldings, rails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.block import blob, block
from avsec_gym.world.models.vehicles.car_body import CarBody, shoulder_height
from avsec_gym.world.models.vehicles.designs import CarDesign
from avsec_gym.world.models.vehicles.hull import column_at, on_side, patch
from avsec_gym.world.models.vehicles.paint import CHROME, MIRROR_GLASS, PLASTIC, STEEL, Finish
from avsec_gym.world.models.vehicles.plate import number_plate
from avsec_gym.world.shapes import tube

INTAKE = Material(tint=(0.012, 0.012, 0.013), infrared=0.1)


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
    left, half = body.lower, design.half_width
    nose, sill = design.nose, design.sill
    inner, outer = half * rng.uniform(0.52, 0.66), half * rng.uniform(1.05, 1.22) + 0.05
    columns = column_at(left, 3, np.linspace(outer, inner, 5), front=True)
    edge = on_side(left, columns, np.full(5, np.inf))[:, 2]
    top = left[-1, -1, 2] + 0.6 * (edge - nose) - 0.055
    tall = rng.uniform(0.13, 0.19)
    lamp = Material(f"headlamp/{int(rng.integers(3))}", mirror=0.12, infrared=0.6)
    low = top - tall * np.array([0.55 + 0.4 * rng.random(), 0.95, 1.0, 1.0, 0.9])
    parts = _both(patch(left, columns, low, top, lamp, uv_size=(1.0, 1.0)))
    lamp_low = float(low.min())
    grille_width = inner - 0.03 if rng.random() < 0.6 else half * 0.36
    columns = column_at(left, 3, np.linspace(grille_width, 0.0, 4), front=True)
    grille_low = max(lamp_low + 0.01, nose - 0.19)
    grille = Material(f"grille/{int(rng.integers(4))}", infrared=0.15)
    parts += _both(patch(left, columns, grille_low, nose - 0.065, grille, uv_size=(0.5, 1.0)))
    middle = on_side(left, len(left) - 1, 0.5 * (grille_low + nose - 0.065))
    badge = blob(0.024, 0.11, 0.11, CHROME)
    parts.append(badge.placed(float(middle[0]) + 0.015, 0.0, float(middle[2])))
    # Below the bumper: the air intake and fog lamps, and a black lip.
    wide = half * rng.uniform(0.45, 0.95)
    columns = column_at(left, 1, np.linspace(wide, 0.0, 5), front=True)
    parts += _both(patch(left, columns, sill + 0.10, sill + rng.uniform(0.17, 0.24), INTAKE))
    parts += _moulding(finish, body, design, front=True)
    plate_z = float(np.clip(0.5 * (sill + 0.24 + lamp_low), sill + 0.24, nose - 0.3))
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
    columns = column_at(body.lower, 3, np.linspace(far, 0.0, 8), front=front)
    high = design.sill + (0.33 if design.height < 2.2 else 0.38)
    places = columns if front else columns[::-1]
    return _both(patch(body.lower, places, high - 0.055, high, PLASTIC, rows=2))


def _rear(rng: np.random.Generator, design: CarDesign, finish: Finish, body: CarBody) -> list[Mesh]:
    left, half = body.lower, design.half_width
    belt, sill = design.belt, design.sill
    red = Material(f"tail_lamp/{int(rng.integers(3))}", mirror=0.1, infrared=0.6)
    if rng.random() < 0.15:
        red = replace(red, glow=0.5)
    upright = design.body.tailgate < 0.3
    inner = half * (0.84 if upright else rng.uniform(0.55, 0.78))
    outer = half * 1.0 + (0.06 if upright else rng.uniform(0.05, 0.2))
    columns = column_at(left, 3, np.linspace(inner, outer, 4), front=False)
    high = belt - 0.06
    tall = rng.uniform(0.26, 0.40) if upright else rng.uniform(0.15, 0.24)
    low = high - tall * np.array([0.9, 1.0, 1.0, rng.uniform(0.5, 0.95)])
    parts = _both(patch(left, columns, low, high, red, uv_size=(1.0, 1.0)))
    parts += _moulding(finish, body, design, front=False)
    low_plate = rng.random() < 0.25 or design.height > 2.1
    lamp_low = float(low.max())
    plate_z = sill + 0.30 if low_plate else 0.5 * (lamp_low + high) - 0.02
    behind = float(on_side(left, [0, 0], [plate_z - 0.05, plate_z + 0.05])[:, 0].min())
    parts.append(number_plate(finish.plate, behind - 0.02, plate_z, front=False))
    # The shut line under the tailgate, and the exhaust.
    columns = column_at(left, 3, np.linspace(0.0, 0.86 * half, 4), front=False)
    gap = sill + 0.37
    parts += _both(patch(left, columns, gap, gap + 0.016, INTAKE, lifted=0.006, rows=2))
    pipe_x = float(left[0, 0, 0]) + 0.03
    pipe = tube([(pipe_x + 0.2, 0, 0), (pipe_x - 0.02, 0, 0)], 0.03, STEEL, sides=6)
    parts.append(pipe.placed(0.0, float(rng.choice([-0.6, 0.6])) * half, sill + 0.035))
    return parts


def _sides(
    rng: np.random.Generator, design: CarDesign, finish: Finish, body: CarBody
) -> list[Mesh]:
    parts = _sign(rng, design, body)
    x = design.bonnet - 0.42
    base = float(shoulder_height(design, np.array([x]))[0])
    inside = design.half_width - 0.10
    outside = design.half_width + 0.045
    tall = 0.19 if design.height < 2.1 else 0.30
    depth = 0.085
    shell = PLASTIC if rng.random() < 0.3 or finish.bumper is PLASTIC else finish.paint
    middle = 0.5 * (inside + outside) + 0.02
    mirror = blob(2.0 * depth, 2.0 * (outside - middle), tall, shell)
    mirror = mirror.placed(x, middle, base + 0.45 * tall)
    glass = block(0.004, 1.35 * (outside - middle), 0.62 * tall, MIRROR_GLASS)
    parts += _both(mirror)
    parts += _both(glass.placed(x - depth - 0.002, middle, base + 0.14 * tall))
    if finish.strip is PLASTIC and rng.random() < 0.45:
        radius = design.wheel + 0.1
        at = np.linspace(design.rear_axle + radius, design.front_axle - radius, 6)
        line = body.lower[:, 3, 0]
        columns = np.interp(at, line, np.arange(len(line)))
        z = design.sill + 0.36 * (base - design.sill)
        parts += _both(patch(body.lower, columns, z, z + 0.06, PLASTIC, rows=2))
    return parts


def _sign(rng: np.random.Generator, design: CarDesign, body: CarBody) -> list[Mesh]:
    """A firm's name on the flank of a delivery van."""
    if design.name not in ("large van", "panel van", "delivery car") or rng.random() < 0.4:
        return []
    radius = design.wheel + 0.12
    at = np.linspace(design.rear_axle + radius, design.front_axle - radius - 0.5, 4)
    line = body.lower[:, 3, 0]
    columns = np.interp(at, line, np.arange(len(line)))
    low = design.sill + 0.42 * (design.belt - design.sill)
    name = Material(f"van_sign/{int(rng.integers(6))}", mirror=0.04, infrared=0.5)
    left = patch(body.lower, columns, low, design.belt - 0.10, name, rows=3, uv_size=(1.0, 1.0))
    # The letters run from the rear to the front on the right side.
    right = left.mirrored()
    return [left, replace(right, uv=(right.uv * [-1.0, 1.0] + [1.0, 0.0]).astype(np.float32))]


def _on_roof(rng: np.random.Generator, design: CarDesign, body: CarBody) -> list[Mesh]:
    long_roof = design.name in ("estate", "off-roader", "people carrier")
    if design.height < 1.6 and rng.random() < 0.03:
        return [_roof_box(design)]
    if not (long_roof and rng.random() < 0.6):
        return []
    x = np.linspace(design.roof_rear + 0.05, design.roof_front - 0.15, 6)
    edge = body.upper[:, -1]
    order = np.argsort(edge[:, 0])
    z = np.interp(x, edge[order, 0], edge[order, 2]) + np.array(
        [0.0, 0.045, 0.05, 0.05, 0.045, 0.0]
    )
    y = np.interp(x, edge[order, 0], edge[order, 1]) - 0.01
    material = PLASTIC if rng.random() < 0.6 else STEEL
    return _both(tube(np.column_stack([x, y, z]), 0.017, material, sides=5))


def _roof_box(design: CarDesign) -> Mesh:
    """A luggage box; it stands above the body, which shrinks to leave room for it."""
    middle = 0.5 * (design.roof_front + design.roof_rear)
    case = blob(1.05 * (design.roof_front - design.roof_rear), 0.8, 0.36, PLASTIC)
    return case.placed(middle, 0.15 * design.half_width, design.height - 0.04)
