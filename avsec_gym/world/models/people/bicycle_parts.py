"""The parts of a bicycle: wheels, frame, mudguards and all that is needed in town."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.models.people.rings import Rings, rods, sweep
from avsec_gym.world.models.people.skin import grouped

WHEEL_RADIUS = 0.35
"""Metres, tyre included."""
CRANK = 0.17
"""Length of a crank, metres."""

_RUBBER = Material(tint=(0.03, 0.03, 0.03), infrared=0.06)
ALLOY = Material(tint=(0.42, 0.42, 0.43), mirror=0.25, infrared=0.5)
BLACK = Material(tint=(0.035, 0.035, 0.037), mirror=0.03, infrared=0.1)
_GLASS = Material(tint=(0.75, 0.77, 0.80), mirror=0.1, infrared=0.9)
_RED = Material(tint=(0.45, 0.02, 0.02), mirror=0.05, infrared=1.0)
_LEATHER = Material("leather", (0.09, 0.05, 0.03), infrared=0.3)


@dataclass(frozen=True)
class Bicycle:
    """Where things are; x forward, z up, metres, the origin on the ground between the wheels.

    Args:
        saddle: Height of the saddle's top.
        wheelbase: Distance between the hubs.
        grip: Half the handlebar's width.
        step_through: Whether the frame has no top tube.
        sporty: A straight handlebar, no chain guard.
        basket: Place of the basket, before the handlebar or on the rack: none, front, rear.
        paint: Material of the frame.
    """

    saddle: float = 0.95
    wheelbase: float = 1.05
    grip: float = 0.28
    step_through: bool = False
    sporty: bool = False
    basket: str = "none"
    paint: Material = BLACK

    @property
    def cranks(self) -> Floats:
        """The axle of the pedals."""
        return np.array([-0.5 * self.wheelbase + 0.45, 0.0, 0.285])

    @property
    def seat(self) -> Floats:
        """The saddle's middle, on top."""
        return np.array([self.cranks[0] - 0.36 * (self.saddle - 0.285), 0.0, self.saddle])

    @property
    def hands(self) -> Floats:
        """The middles of the grips, right and left, shape (2, 3)."""
        back, high = (0.17, 1.02) if self.sporty else (0.37, 1.07)
        x = 0.5 * self.wheelbase - back
        return np.array([(x, -self.grip, high), (x, self.grip, high)])

    def pedals(self, phase: float) -> Floats:
        """Pedals, right and left, shape (2, 3); at phase 0 the right one is on top."""
        angle = 2.0 * np.pi * np.array([phase, phase + 0.5])
        way = np.stack([np.sin(angle), np.zeros(2), np.cos(angle)], axis=1)
        return np.asarray(self.cranks + CRANK * way + np.array([(0, -0.12, 0), (0, 0.12, 0)]))


def bicycle_parts(bicycle: Bicycle, phase: float) -> list[Rings]:
    """The bicycle with its cranks turned by `phase` revolutions."""
    hubs = (-0.5 * bicycle.wheelbase, 0.5 * bicycle.wheelbase)
    spokes = [_spokes(x, 3.0 * phase) for x in hubs]
    return [*_still_parts(bicycle), *spokes, *_drive(bicycle, phase)]


@functools.lru_cache(maxsize=128)
def _still_parts(bicycle: Bicycle) -> tuple[Rings, ...]:
    """What does not turn, or looks the same when it does."""
    parts = [_frame(bicycle), _fork(bicycle), *_handlebar(bicycle), _saddle(bicycle)]
    for x in (-0.5 * bicycle.wheelbase, 0.5 * bicycle.wheelbase):
        parts += _wheel(x)
        if not bicycle.sporty:
            parts.append(_mudguard(x, bicycle))
    return tuple(grouped([*parts, *_extras(bicycle)]))


def _wheel(x: float) -> list[Rings]:
    """Tyre and rim in one, and the hub; the wheel goes along with its hub."""
    angle = np.linspace(0.0, 2.0 * np.pi, 25)
    round_ = np.stack([np.cos(angle), 0.0 * angle, np.sin(angle)], axis=1)
    hub = np.array([x, 0.0, WHEEL_RADIUS])
    forward = np.stack([-np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    codes = np.zeros((25, 6), np.int32)
    codes[:, [2, 3]] = 1
    give = (np.sign(x), 0.0, 0.0)
    centre = WHEEL_RADIUS - 0.022
    tyre = sweep(
        hub + centre * round_,
        forward,
        round_,
        (0.022, 0.020, 0.019),
        (_RUBBER, ALLOY),
        sides=6,
        codes=codes,
        give=give,
        capped=False,
    )
    axle = np.array([[x, -0.055, WHEEL_RADIUS]])
    core = rods(axle, axle * [1, -1, 1], 0.022, ALLOY, sides=6, give=(give, give))
    return [tyre, core]


def _spokes(x: float, turns: float) -> Rings:
    hub, give = np.array([x, 0.0, WHEEL_RADIUS]), (np.sign(x), 0.0, 0.0)
    spin = -2.0 * np.pi * turns + np.arange(18) * (2.0 * np.pi / 18)
    way = np.stack([np.cos(spin), 0.0 * spin, np.sin(spin)], axis=1)
    flange = np.stack([0.0 * spin, np.where(np.arange(18) % 2, 0.03, -0.03), 0.0 * spin], axis=1)
    return rods(
        hub + 0.03 * way + flange,
        hub + (WHEEL_RADIUS - 0.04) * way,
        0.0020,
        ALLOY,
        sides=3,
        give=(give, give),
    )


def _mudguard(x: float, bicycle: Bicycle) -> Rings:
    first, last = (np.radians(25), np.radians(190)) if x < 0 else (np.radians(20), np.radians(170))
    angle = np.linspace(first, last, 11)
    round_ = np.stack([np.cos(angle), 0.0 * angle, np.sin(angle)], axis=1)
    forward = np.stack([-np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    centres = _at(x, z=WHEEL_RADIUS) + (WHEEL_RADIUS + 0.016) * round_
    material = bicycle.paint if bicycle.step_through else BLACK
    give = (np.sign(x), 0.0, 0.0)
    return sweep(centres, forward, round_, (0.008, 0.004, 0.027), material, sides=4, give=give)


def _frame(bicycle: Bicycle) -> Rings:
    half = 0.5 * bicycle.wheelbase
    crank, seat = bicycle.cranks, bicycle.seat
    cluster = crank + (seat - crank) * ((0.80 - crank[2]) / (seat[2] - crank[2]))
    head_low, head_top = np.array([half - 0.125, 0.0, 0.69]), np.array([half - 0.175, 0.0, 0.84])
    low = crank + 0.45 * (cluster - crank)
    pairs = [
        (crank, cluster, 0.017),
        (cluster, seat - _at(z=0.04), 0.013),
        (crank, head_low, 0.020),
        (head_low, head_top, 0.020),
        (low, head_top, 0.017)
        if bicycle.step_through
        else (cluster, head_top - _at(z=0.02), 0.016),
    ]
    for side in (-1.0, 1.0):
        dropout = np.array([-half, side * 0.065, WHEEL_RADIUS])
        pairs.append((crank + _at(y=side * 0.03), dropout, 0.011))
        pairs.append((cluster + _at(y=side * 0.02), dropout, 0.010))
    starts, ends, radii = (np.array(column) for column in zip(*pairs, strict=True))
    return rods(starts, ends, radii, bicycle.paint)


def _fork(bicycle: Bicycle) -> Rings:
    half = 0.5 * bicycle.wheelbase
    crown = np.array([half - 0.125, 0.0, 0.69])
    starts = np.array([crown + _at(y=side * 0.045) for side in (-1, 1)])
    ends = np.array([(half, side * 0.052, WHEEL_RADIUS) for side in (-1, 1)])
    bridge = starts[:1], starts[1:]
    return rods(
        np.concatenate([starts, bridge[0]]), np.concatenate([ends, bridge[1]]), 0.013, bicycle.paint
    )


def _drive(bicycle: Bicycle, phase: float) -> list[Rings]:
    """Cranks, pedals, chain wheel and chain guard."""
    pedals = bicycle.pedals(phase)
    axle = bicycle.cranks
    inner = np.array([axle + _at(y=side * 0.07) for side in (-1, 1)])
    arms = rods(inner, pedals * [1, 0, 1] + inner * [0, 1, 0], 0.011, ALLOY)
    blocks = [
        sweep(
            pedal + np.array([(-0.045, 0, 0), (0.045, 0, 0)]),
            (1, 0, 0),
            (0, 0, 1),
            (0.011, 0.011, 0.045),
            BLACK,
            sides=4,
            squareness=1.0,
        )
        for pedal in pedals
    ]
    wheel = rods((axle + _at(y=-0.05))[None], (axle + _at(y=-0.042))[None], 0.085, ALLOY, sides=12)
    if bicycle.sporty:
        hub = np.array([-0.5 * bicycle.wheelbase, -0.046, WHEEL_RADIUS])
        offset = np.array([0.0, -0.046, 0.085])
        chain = rods(
            np.array([axle + offset, axle + offset * [1, 1, -1]]),
            np.array([hub + _at(z=0.035), hub - _at(z=0.035)]),
            0.005,
            BLACK,
            sides=4,
        )
        return [arms, wheel, chain, *blocks]
    places = axle + np.array(
        [(0.11, -0.046, 0.01), (0.05, -0.046, 0.01), (-0.36, -0.046, 0.055), (-0.48, -0.046, 0.065)]
    )
    sizes = np.array(
        [(0.03, 0.03, 0.009), (0.095, 0.095, 0.012), (0.055, 0.055, 0.012), (0.03, 0.03, 0.009)]
    )
    guard = sweep(places, (-1, 0, 0), (0, 0, 1), sizes, BLACK)
    return [arms, guard, *blocks]


def _handlebar(bicycle: Bicycle) -> list[Rings]:
    half = 0.5 * bicycle.wheelbase
    x, grip, high = bicycle.hands[1]
    top = np.array([half - 0.19, 0.0, high - 0.035])
    if bicycle.sporty:
        line = np.array(
            [(x, grip + 0.06, high), (x, grip - 0.06, high), (top[0] + 0.04, 0.02, high - 0.01)]
        )
    else:
        line = np.array(
            [
                (x - 0.06, grip + 0.01, high - 0.01),
                (x + 0.06, grip, high),
                (x + 0.16, 0.6 * grip, high),
                (top[0] + 0.02, 0.03, high - 0.02),
            ]
        )
    line = np.concatenate([line, line[::-1] * [1, -1, 1]])
    tangents = np.gradient(line, axis=0)
    codes = np.zeros((len(line), 1), np.int32)
    codes[[1, -1]] = 1
    thick = np.full((len(line), 3), 0.012)
    thick[[0, 1, -2, -1]] = 0.016
    bar = sweep(line, tangents, (0, 0, 1), thick, (ALLOY, BLACK), sides=5, codes=codes)
    stem = rods(np.array([(half - 0.175, 0.0, 0.83)]), (top + _at(0.02))[None], 0.014, ALLOY)
    return [bar, stem]


def _saddle(bicycle: Bicycle) -> Rings:
    places = bicycle.seat + np.array(
        [(-0.13, 0, -0.03), (-0.09, 0, -0.032), (0.02, 0, -0.03), (0.15, 0, -0.026)]
    )
    sizes = np.array(
        [(0.022, 0.02, 0.06), (0.032, 0.03, 0.09), (0.026, 0.026, 0.05), (0.018, 0.015, 0.016)]
    )
    return sweep(places, (1, 0, 0), (0, 0, 1), sizes, _LEATHER if bicycle.step_through else BLACK)


def _extras(bicycle: Bicycle) -> list[Rings]:
    """Lamps, rack and basket."""
    half = 0.5 * bicycle.wheelbase
    lamp = np.array([(half - 0.13, 0, 0.80), (half - 0.08, 0, 0.80), (half - 0.06, 0, 0.80)])
    parts = [
        sweep(lamp, (1, 0, 0), (0, 0, 1), np.array([[0.02], [0.034], [0.034]]), BLACK),
        sweep(
            np.array([lamp[2] + _at(0.001), lamp[2] + _at(0.008)]),
            (1, 0, 0),
            (0, 0, 1),
            (0.03, 0.03, 0.03),
            _GLASS,
        ),
    ]
    back = np.array([-half - 0.19, 0.0, 0.745])
    if bicycle.sporty:
        back = bicycle.seat + _at(-0.05, z=-0.14)
    parts.append(
        sweep(np.array([back - _at(0.025), back]), (1, 0, 0), (0, 0, 1), (0.025, 0.025, 0.03), _RED)
    )
    if bicycle.sporty:
        return parts
    rear, front = -half - 0.19, -half + 0.17
    bars = [((rear, side * 0.06, 0.765), (front, side * 0.06, 0.775)) for side in (-1, 1)]
    bars += [
        ((-half - 0.06, side * 0.06, 0.765), (-half, side * 0.07, WHEEL_RADIUS)) for side in (-1, 1)
    ]
    bars += [
        ((rear, -0.06, 0.765), (rear, 0.06, 0.765)),
        ((front, -0.06, 0.775), (front, 0.06, 0.775)),
    ]
    ends = np.array(bars)
    parts.append(rods(ends[:, 0], ends[:, 1], 0.006, BLACK, sides=4))
    if bicycle.basket == "front":
        parts.append(_basket(np.array([half - 0.02, 0.0, 0.86]), 0.13, 0.17))
    elif bicycle.basket == "rear":
        parts.append(_basket(np.array([-half - 0.01, 0.0, 0.785]), 0.17, 0.14))
    return parts


def _basket(bottom: Floats, half_length: float, half_width: float) -> Rings:
    wicker = Material("knit/1", (0.20, 0.13, 0.07), infrared=0.5)
    places = bottom + np.array([(0, 0, 0), (0, 0, 0.20)])
    sizes = np.array([(0.8, 0.8, 0.8), (1.0, 1.0, 1.0)]) * [half_length, half_length, half_width]
    return sweep(places, (0, 0, 1), (1, 0, 0), sizes, wicker, squareness=0.6)


def _at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Floats:
    return np.array([x, y, z])
