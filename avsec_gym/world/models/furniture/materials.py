"""What street furniture is made of."""

from __future__ import annotations

from avsec_gym.world.material import Material

GALVANISED = Material("galvanised", mirror=0.06, infrared=0.5)
ALUMINIUM = Material("galvanised", (0.8, 0.8, 0.82), mirror=0.1, infrared=0.5)
CONCRETE = Material("cast_concrete/0", infrared=0.4)
GREY_CONCRETE = Material("cast_concrete/1", infrared=0.4)
RAW_CONCRETE = Material("raw_concrete", infrared=0.4)
BLACK_PLASTIC = Material(tint=(0.02, 0.02, 0.022), mirror=0.03, infrared=0.1)
WHITE_PLASTIC = Material(tint=(0.78, 0.79, 0.79), mirror=0.03, infrared=0.7)
CAST_IRON = Material(tint=(0.025, 0.035, 0.03), mirror=0.04, infrared=0.3)
RUST = Material("rusty", infrared=0.4)
WOOD = Material("weathered_wood/0", infrared=0.5)
UPRIGHT_WOOD = Material("weathered_wood/1", infrared=0.5)
OPAL_GLASS = Material(tint=(0.92, 0.92, 0.9), mirror=0.05, infrared=0.6)
DARK_GLASS = Material(tint=(0.06, 0.08, 0.08), mirror=0.1, glass=True)
SOIL = Material(tint=(0.05, 0.035, 0.025), infrared=0.3)


def painted(
    red: float, green: float, blue: float, *, worn: int = 0, infrared: float = 0.5
) -> Material:
    """Painted metal or plastic of a colour in linear light.

    Args:
        red: Red part of the colour, in 0..1.
        green: Green part, in 0..1.
        blue: Blue part, in 0..1.
        worn: Degree of wear from 0, only weathered, to 3, with many stickers and scrawls.
        infrared: LiDAR reflectance.
    """
    return Material(f"scribbled/{worn}", (red, green, blue), mirror=0.03, infrared=infrared)
