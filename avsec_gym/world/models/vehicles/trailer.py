"""Misc: trailers, caravans, a tractor, motor scooters and bins, whichever fits the size."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.block import blob, block
from avsec_gym.world.models.vehicles.cargo import cargo_box, platform
from avsec_gym.world.models.vehicles.coach import BodyBand, coach
from avsec_gym.world.models.vehicles.hull import surface
from avsec_gym.world.models.vehicles.lorry import facing
from avsec_gym.world.models.vehicles.paint import (
    CHROME,
    PLASTIC,
    RUBBER,
    SEAT,
    STEEL,
    UNDERSIDE,
    draw_finish,
    glass,
)
from avsec_gym.world.models.vehicles.plate import PLATES, number_plate
from avsec_gym.world.models.vehicles.wheel import wheel
from avsec_gym.world.shapes import tube

_RED_LAMP = Material("tail_lamp/1", mirror=0.08, infrared=0.6)


def misc(rng: np.random.Generator, height: float, width: float, length: float) -> list[Mesh]:
    """Parts of a thing on wheels that is no car, for its size."""
    if length > 7.5:
        return _semi_trailer(rng, height, width, length)
    if width < 0.9 and length > 1.3:
        return _scooter(rng, height, width, length)
    if width < 0.9 or length < 1.3:
        return _container(rng, height, width, length)
    if length > 3.2 and height > 1.9:
        return (_caravan if rng.random() < 0.8 else _tractor)(rng, height, width, length)
    return _small_trailer(rng, height, width, length)


def _running_gear(
    x: float, radius: float, half: float, rear: float, deck: float, plate: int
) -> list[Mesh]:
    """Two wheels with mudguards, rear lamps and a plate."""
    tyre = wheel(7, 0.6).scaled(radius, 0.5 * radius, radius).placed(x, half, radius)
    angle = np.linspace(0.1, np.pi - 0.1, 8)
    outward = np.stack([np.cos(angle), np.zeros(8), np.sin(angle)], axis=-1)
    edges = np.array([[x, half, radius], [x, half - 0.34 * radius, radius]])
    arc = edges[None] + 1.14 * radius * outward[:, None]
    guard = surface(arc, np.repeat(outward[:, None], 2, axis=1), PLASTIC)
    parts = [tyre, tyre.mirrored(), guard, guard.mirrored()]
    parts.append(block(0.08, 2.0 * half - 0.1, 0.08, UNDERSIDE).placed(x, 0.0, radius - 0.04))
    for side in (-1.0, 1.0):
        parts.append(
            facing(rear + 0.01, side * (0.68 * half), deck - 0.06, 0.22, 0.12, _RED_LAMP, -1.0)
        )
    share = min(1.0, 0.9 * half)
    parts.append(number_plate(plate, rear - 0.012, deck - 0.06, front=False, share=share))
    return parts


def _drawbar(front: float, start: float, half: float, z: float) -> list[Mesh]:
    parts = [
        tube([(start, side * 0.7 * half, z), (front - 0.06, 0.0, z)], 0.035, STEEL, sides=6)
        for side in (-1.0, 1.0)
    ]
    parts.append(blob(0.12, 0.1, 0.12, PLASTIC).placed(front - 0.06, 0.0, z))
    parts.append(
        tube([(front - 0.3, 0.0, 0.0), (front - 0.3, 0.0, z + 0.1)], 0.025, STEEL, sides=6)
    )
    return parts


def _small_trailer(
    rng: np.random.Generator, height: float, width: float, length: float
) -> list[Mesh]:
    """An open or covered car trailer."""
    # The box, behind a drawbar and above the wheels.
    half, front, rear = 0.5 * width, 0.5 * length, -0.5 * length
    radius = float(np.clip(0.2 * height, 0.20, 0.30))
    bar = min(0.9, 0.28 * length)
    box_front = front - bar
    deck = 1.5 * radius + 0.08
    side_top = min(height, deck + min(0.42, 0.4 * height))
    inner = half - 0.5 * radius - 0.02 if width > 1.0 else half - 0.3 * radius
    metal = Material(tint=(0.36, 0.37, 0.38), mirror=0.1, infrared=0.5)
    parts = platform(rear, box_front, inner, deck, side_top, metal)
    # A tarpaulin where the labelled height leaves room, else a load now and then.
    if height > side_top + 0.15:
        colours = (
            (0.03, 0.045, 0.10),
            (0.10, 0.10, 0.11),
            (0.02, 0.08, 0.05),
            (0.35, 0.35, 0.34),
            (0.25, 0.03, 0.03),
        )
        tint = colours[int(rng.integers(len(colours)))]
        cover = Material("tarpaulin", tint, infrared=0.35)
        cloth = [
            BodyBand(0.5 * (side_top + height), cover),
            BodyBand(height, cover, inset=0.01, lean=0.01),
        ]
        tarp, _ = coach(
            rear,
            box_front,
            inner + 0.015,
            side_top - 0.12,
            cloth,
            rounding=(0.08, 0.08),
            squareness=6.0,
        )
        parts += tarp
    elif rng.random() < 0.5:
        heap = blob(0.8 * (box_front - rear), 1.6 * inner, 1.6 * (side_top - deck), SEAT)
        parts.append(heap.placed(0.5 * (rear + box_front), 0.0, deck))
    # One axle, or two below a long box.
    axle = 0.5 * (rear + box_front) - 0.1
    gear = _running_gear(axle, radius, half, rear, deck, int(rng.integers(PLATES)))
    if length > 3.7:
        second = wheel(7, 0.6).scaled(radius, 0.5 * radius, radius)
        second = second.placed(axle - 2.5 * radius, half, radius)
        gear += [second, second.mirrored()]
    return [*parts, *gear, *_drawbar(front, box_front - 0.2, inner, deck - 0.05)]


def _caravan(rng: np.random.Generator, height: float, width: float, length: float) -> list[Mesh]:
    """A caravan, or a trailer with a closed body."""
    half, front, rear = 0.5 * width, 0.5 * length, -0.5 * length
    body_front = front - 0.2 * length
    radius = 0.32
    axle = 0.5 * (rear + body_front) - 0.1
    white = Material(tint=(0.70, 0.70, 0.67), mirror=0.04, infrared=0.6)
    stripe_tint = ((0.10, 0.14, 0.30), (0.30, 0.22, 0.10), (0.25, 0.25, 0.26))[int(rng.integers(3))]
    stripe = Material(tint=stripe_tint, mirror=0.04, infrared=0.4)
    pane = glass("side_glass/1")
    third = (body_front - rear) / 3.0
    windows: tuple[tuple[float, float, Material], ...] = (
        (rear + 0.25, rear + 0.9 * third, pane),
        (body_front - 1.1 * third, body_front - 0.3, pane),
    )
    if rng.random() < 0.3:
        # A box trailer has no windows.
        windows, pane = (), white
    bands = [
        BodyBand(0.34 * height, white),
        BodyBand(0.38 * height, stripe),
        BodyBand(0.50 * height, white),
        BodyBand(
            0.74 * height, white, front=pane, rear=pane, openings=windows, lean=0.08, inset=0.01
        ),
        BodyBand(height, white, lean=0.30, inset=0.03),
    ]
    parts, _ = coach(
        rear,
        body_front,
        half,
        0.28,
        bands,
        axles=[axle],
        wheel=radius,
        rounding=(0.2, 0.25),
        squareness=5.0,
        rear_lean=0.6,
    )
    gear = _running_gear(axle, radius, half - 0.04, rear + 0.005, 0.5, int(rng.integers(PLATES)))
    return [*parts, *gear, *_drawbar(front, body_front - 0.1, half, 0.42)]


def _semi_trailer(
    rng: np.random.Generator, height: float, width: float, length: float
) -> list[Mesh]:
    """The rear part of an articulated lorry, parked on its legs."""
    half, front, rear = 0.5 * width, 0.5 * length, -0.5 * length
    radius = 0.47
    deck = 1.1
    parts = cargo_box(rng, rear, front, half, deck, height)
    parts.append(block(length - 0.4, 0.9, 0.25, UNDERSIDE).placed(0.0, 0.0, deck - 0.25))
    for axle in (rear + 1.6, rear + 2.9, rear + 4.2):
        tyre = wheel(7, 0.56).scaled(radius, 0.8 * radius, radius).placed(axle, half - 0.06, radius)
        parts += [tyre, tyre.mirrored()]
        parts.append(block(0.16, 1.8 * half, 0.16, UNDERSIDE).placed(axle, 0.0, radius - 0.08))
    for side in (-1.0, 1.0):
        parts.append(block(0.14, 0.14, deck, STEEL).placed(front - 2.6, side * 0.6 * half, 0.0))
        parts.append(
            facing(rear + 0.02, side * (half - 0.3), deck - 0.16, 0.42, 0.13, _RED_LAMP, -1.0)
        )
    parts.append(block(0.10, 1.8 * half, 0.12, STEEL).placed(rear + 0.06, 0.0, radius))
    parts.append(number_plate(int(rng.integers(PLATES)), rear, deck - 0.16, front=False))
    return parts


def _tractor(rng: np.random.Generator, height: float, width: float, length: float) -> list[Mesh]:
    """A farm tractor or a loader: large wheels, a glass cab, a bonnet."""
    paint = draw_finish(rng, "plain", commercial=True).paint
    tint = ((0.55, 0.30, 0.01), (0.02, 0.12, 0.03), (0.40, 0.03, 0.02))[int(rng.integers(3))]
    paint = Material(tint=tint, mirror=paint.mirror, infrared=0.5)
    half, front, rear = 0.5 * width, 0.5 * length, -0.5 * length
    big, small = 0.29 * height, 0.19 * height
    rear_axle, front_axle = rear + big + 0.02, front - small - 0.25
    pane = glass("side_glass/1")
    cab_rear, cab_front = rear + 0.12, rear + 0.12 + 0.42 * length
    cab = [
        BodyBand(0.52 * height, paint),
        BodyBand(
            0.92 * height,
            PLASTIC,
            front=pane,
            rear=pane,
            lean=0.05,
            inset=0.03,
            openings=((cab_rear + 0.12, cab_front - 0.15, pane),),
        ),
        BodyBand(height, paint, lean=0.0, inset=0.0),
    ]
    parts, _ = coach(cab_rear, cab_front, 0.62 * half, 0.3 * height, cab, rounding=(0.1, 0.1))
    bonnet = [BodyBand(0.48 * height, paint), BodyBand(0.56 * height, paint, lean=0.06, inset=0.04)]
    nose, _ = coach(
        cab_front - 0.1, front - 0.12, 0.42 * half, 0.26 * height, bonnet, rounding=(0.1, 0.2)
    )
    parts += nose
    parts.append(
        block(0.12, 0.8 * half, 0.2 * height, STEEL).placed(front - 0.06, 0.0, 0.18 * height)
    )
    for axle, radius in ((rear_axle, big), (front_axle, small)):
        tyre = wheel(6, 0.55).scaled(radius, 0.8 * radius, radius).placed(axle, half, radius)
        parts += [tyre, tyre.mirrored()]
        parts.append(block(0.3, 1.6 * half, 0.3, UNDERSIDE).placed(axle, 0.0, radius - 0.15))
    guard = block(1.7 * big, 0.6 * big, 0.06, paint).placed(
        rear_axle, half - 0.3 * big, 2.0 * big + 0.02
    )
    return [*parts, guard, guard.mirrored()]


def _scooter(rng: np.random.Generator, height: float, width: float, length: float) -> list[Mesh]:
    """A motor scooter or motorcycle on its stand."""
    paint = draw_finish(rng, "plain").paint
    radius = float(np.clip(0.15 * length, 0.18, 0.32))
    front, rear, half = 0.5 * length, -0.5 * length, 0.5 * width
    seat = 0.62 * height
    tyre = wheel(int(rng.integers(8)), 0.7).scaled(radius, 0.2, radius)
    parts = [tyre.placed(x, 0.06, radius) for x in (front - radius, rear + radius)]
    steering = (front - 0.32 * length, 0.0, 0.93 * height)
    parts += [
        tube([(front - radius, 0.0, radius), steering], [0.05, 0.04], STEEL, sides=6),
        tube(
            [
                (front - 0.34 * length, -half + 0.02, 0.94 * height),
                (front - 0.3 * length, 0.0, 0.92 * height),
                (front - 0.34 * length, half - 0.02, 0.94 * height),
            ],
            0.02,
            RUBBER,
            sides=6,
        ),
        blob(0.14, 0.3, 0.34 * height, paint).placed(front - 0.27 * length, 0.0, 0.66 * height),
        blob(0.40 * length, 0.26, 0.12 * height, SEAT).placed(rear + 0.36 * length, 0.0, seat),
        blob(0.52 * length, 0.30, 0.34 * height, paint).placed(
            rear + 0.34 * length, 0.0, 0.46 * height
        ),
        block(0.40 * length, 0.28, 0.16 * height, PLASTIC).placed(0.0, 0.0, 0.24 * height),
        blob(0.10, 0.16, 0.14, CHROME).placed(front - 0.22 * length, 0.0, 0.8 * height),
        blob(0.08, 0.16, 0.09, _RED_LAMP).placed(rear + 0.08 * length, 0.0, 0.55 * height),
        blob(0.1, 0.06, 0.08, PLASTIC).placed(front - 0.3 * length, half - 0.03, height - 0.04),
        blob(0.1, 0.06, 0.08, PLASTIC).placed(front - 0.3 * length, 0.03 - half, height - 0.04),
    ]
    parts.append(
        number_plate(int(rng.integers(PLATES)), rear + 0.03, 0.42 * height, front=False, share=0.45)
    )
    return parts


def _container(rng: np.random.Generator, height: float, width: float, length: float) -> list[Mesh]:
    """A large bin on castors."""
    colours = ((0.05, 0.055, 0.06), (0.02, 0.08, 0.03), (0.03, 0.06, 0.20), (0.30, 0.20, 0.02))
    paint = Material(tint=colours[int(rng.integers(len(colours)))], mirror=0.02, infrared=0.3)
    half, front, rear = 0.5 * width, 0.5 * length, -0.5 * length
    lid = Material(tint=(0.04, 0.04, 0.045), mirror=0.02, infrared=0.2)
    bands = [
        BodyBand(0.5 * height, paint, lean=0.03, inset=0.03),
        BodyBand(0.88 * height, paint, lean=0.0, inset=0.0),
        BodyBand(height, lid, lean=0.02, inset=0.02),
    ]
    parts, _ = coach(
        rear, front, half, 0.12, bands, rounding=(0.08, 0.08), squareness=6.0, rear_lean=1.0
    )
    castor = wheel(7, 0.4).scaled(0.09, 0.1, 0.09)
    for x in (rear + 0.15, front - 0.15):
        placed = castor.placed(x, half - 0.06, 0.09)
        parts += [placed, placed.mirrored()]
    return parts
