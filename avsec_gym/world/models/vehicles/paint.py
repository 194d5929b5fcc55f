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
LINING = Material(tint=(0.03, 0.03, 0.032), infrared=0.2)
CLOTH = Material(tint=(0.016, 0.016, 0.017), infrared=0.2)
TRIM = Material(tint=(0.45, 0.45, 0.45), mirror=0.35, infrared=0.5)
MIRROR_GLASS = Material(tint=(0.3, 0.3, 0.3), mirror=0.7, infrared=0.1)

_CLEAR_COAT = 0.045
"""Share of light that varnish mirrors straight on."""
_SEATS = (
    SEAT,
    Material(tint=(0.10, 0.10, 0.105), infrared=0.3),
    Material(tint=(0.22, 0.18, 0.13), infrared=0.35),
)

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
_METALLIC = (1.0, 0.6, 0.95, 0.9, 0.8, 0.8, 0.0, 0.15, 0.6, 0.6, 0.8, 0.9, 0.0, 0.8)
"""How often each colour has flakes of metal in it."""
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
        back_glass: The side windows behind the front seats.
        trim: The strip under the side windows.
        seat: Covers of the seats.
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
    back_glass: Material
    trim: Material
    seat: Material
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
    flakes = float(rng.uniform(0.35, 0.75)) if rng.random() < _METALLIC[kind] else 0.0
    flakes = 0.0 if commercial else round(flakes, 2)

    def painted(texture: str = "plain") -> Material:
        return Material(texture, tint, _CLEAR_COAT, flakes=flakes, infrared=infrared)

    paint = painted()
    plain_bumper = rng.random() < (0.45 if commercial else 0.06)
    strip = PLASTIC if rng.random() < 0.25 else paint
    tinted = int(rng.choice(2, p=(0.7, 0.3)))
    # Behind the front seats some have glass that keeps the sun out.
    private = 2 if rng.random() < 0.2 else tinted
    return Finish(
        paint=paint,
        bonnet=painted("bonnet"),
        flank=painted(flank),
        bumper=PLASTIC if plain_bumper else paint,
        strip=strip,
        side_glass=pane(f"side_pane/{tinted}"),
        windscreen=pane(f"wind_pane/{int(rng.integers(2))}"),
        rear_glass=pane(f"rear_pane/{private}"),
        back_glass=pane(f"side_pane/{private}"),
        trim=TRIM if rng.random() < 0.3 and not commercial else BLACK_GLOSS,
        seat=_SEATS[int(rng.choice(len(_SEATS), p=(0.6, 0.25, 0.15)))],
        plate=int(rng.integers(PLATES)),
    )


def pane(texture: str) -> Material:
    """A window that one sees through; the texture is its tint, with frame, heater or wiper."""
    return Material(texture, mirror=0.07, glass=True, clear=0.96, infrared=0.05)


def glass(texture: str) -> Material:
    """A window of a bus or a lorry: the texture is what shows through it."""
    return Material(texture, mirror=0.08, glass=True, infrared=0.05)
