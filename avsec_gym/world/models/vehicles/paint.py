"""What vehicles are made of: paint in the colours of German roads of 2011, glass, rubber."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.models.vehicles.plate import PLATES

RUBBER = Material(tint=(0.018, 0.018, 0.019), infrared=0.05)
UNDERSIDE = Material(tint=(0.012, 0.012, 0.012), infrared=0.08)
PLASTIC = Material(tint=(0.028, 0.029, 0.031), mirror=0.02, infrared=0.1)
BLACK_GLOSS = Material(tint=(0.010, 0.010, 0.011), mirror=0.05, infrared=0.1)
CHROME = Material(tint=(0.55, 0.55, 0.55), mirror=0.45, infrared=0.6)
STEEL = Material(tint=(0.30, 0.31, 0.32), mirror=0.1, infrared=0.45)
SEAT = Material(tint=(0.04, 0.04, 0.045), infrared=0.25)
MIRROR_GLASS = Material(tint=(0.3, 0.3, 0.3), mirror=0.7, infrared=0.1)

_COLOURS = (
    # share; red, green, blue in linear light; infrared
    (0.20, (0.42, 0.43, 0.44), 0.55),  # silver
    (0.23, (0.012, 0.012, 0.013), 0.10),  # black
    (0.11, (0.060, 0.064, 0.070), 0.30),  # dark grey
    (0.07, (0.20, 0.21, 0.22), 0.45),  # grey
    (0.11, (0.010, 0.022, 0.080), 0.35),  # dark blue
    (0.04, (0.05, 0.13, 0.32), 0.40),  # light blue
    (0.09, (0.78, 0.78, 0.76), 0.70),  # white
    (0.08, (0.30, 0.012, 0.012), 0.55),  # red
    (0.02, (0.10, 0.008, 0.014), 0.45),  # dark red
    (0.035, (0.012, 0.052, 0.030), 0.35),  # dark green
    (0.015, (0.14, 0.22, 0.13), 0.45),  # light green
    (0.025, (0.36, 0.30, 0.20), 0.60),  # beige, gold
    (0.015, (0.60, 0.38, 0.02), 0.65),  # yellow
    (0.010, (0.10, 0.055, 0.03), 0.40),  # brown
)
_SHARES = np.array([share for share, _, _ in _COLOURS])
_COMMERCIAL = np.array(
    [0.10, 0.04, 0.04, 0.04, 0.08, 0.05, 0.48, 0.07, 0.0, 0.03, 0.01, 0.01, 0.05, 0.0]
)


@dataclass(frozen=True)
class Finish:
    """The surfaces of one vehicle.

    Args:
        paint: Material of roof and bonnet.
        bonnet: The same colour with shut lines and wipers.
        flank: The same colour with door seams, handles and road dirt.
        bumper: Paint, or black plastic.
        strip: Mouldings along bumpers and doors.
        side_glass: The side windows.
        windscreen: The front window.
        rear_glass: The rear window.
        plate: Number of its plate.
    """

    paint: Material
    bonnet: Material
    flank: Material
    bumper: Material
    strip: Material
    side_glass: Material
    windscreen: Material
    rear_glass: Material
    plate: int


def draw_finish(rng: np.random.Generator, flank: str, *, commercial: bool = False) -> Finish:
    """Paint, glass and plate by chance.

    Args:
        rng: The source of chance.
        flank: Texture of the sides.
        commercial: Mostly white, as delivery vans are.
    """
    shares = _COMMERCIAL if commercial else _SHARES
    kind = int(rng.choice(len(_COLOURS), p=shares / shares.sum()))
    _, colour, infrared = _COLOURS[kind]
    varied = np.clip(
        np.array(colour) * np.exp(0.15 * rng.standard_normal() + 0.04 * rng.standard_normal(3)),
        0.006,
        0.85,
    )
    tint = (float(varied[0]), float(varied[1]), float(varied[2]))
    infrared = round(float(np.clip(infrared + 0.06 * rng.standard_normal(), 0.05, 0.8)), 2)
    paint = Material(tint=tint, mirror=0.05, infrared=infrared)
    plain_bumper = rng.random() < (0.45 if commercial else 0.12)
    strip = PLASTIC if rng.random() < 0.75 else paint
    window = int(rng.integers(3))
    return Finish(
        paint=paint,
        bonnet=Material("bonnet", tint, 0.05, infrared=infrared),
        flank=Material(flank, tint, 0.05, infrared=infrared),
        bumper=PLASTIC if plain_bumper else paint,
        strip=strip,
        side_glass=glass(f"side_glass/{window}"),
        windscreen=glass(f"windscreen/{int(rng.integers(3))}"),
        rear_glass=glass(f"rear_glass/{int(rng.integers(3))}"),
        plate=int(rng.integers(PLATES)),
    )


def glass(texture: str) -> Material:
    """A window: the texture is what shows through it."""
    return Material(texture, mirror=0.08, glass=True, infrared=0.05)
