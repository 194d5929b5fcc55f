"""What a surface is made of, for light and for LiDAR."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """How a surface answers light.

    Args:
        texture: A name of `avsec_gym.world.textures.library`, such as ``brick/2``; ``plain`` is
            white.
        tint: The texture's colour is multiplied by it: red, green, blue in linear light, so that
            a plain surface of tint 0.5 returns half of the light.
        mirror: Share of the light that is mirrored when looking straight at the surface, 0 for
            dull ones; it grows towards grazing angles (Schlick).  Car paint 0.05, window glass
            0.08, chrome 0.6.
        glass: LiDAR pulses pass without an echo (the camera sees the texture, and reflections).
        translucent: Share of the light on the far side that shines through (leaves 0.4).
        leaves: The surface stands for a spray of leaves: it is drawn leaf by leaf, and light and
            rays pass between them.
        grainy: The texture has grains without order (asphalt, grass): it is drawn twice, at two
            scales, so that its repetition is not seen.
        infrared: LiDAR reflectance in [0, 1]; None for the texture's brightness.  Leaves and
            many paints are bright in the infrared, tyres and dark windows black, number plates
            and road signs (retro-reflectors) 1.
        glow: Light that the surface sends out by itself, in units of sunlit white (a lit brake
            lamp 0.5).
        clear: Share of the light from behind a pane that the camera sees through it; the texture
            is the pane's tint.
        flakes: Share of the paint's own light that flakes of metal send round the direction of a
            mirror, so that panels towards the sun are bright and others dark.
    """

    texture: str = "plain"
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    mirror: float = 0.0
    glass: bool = False
    translucent: float = 0.0
    leaves: bool = False
    grainy: bool = False
    infrared: float | None = None
    glow: float = 0.0
    clear: float = 0.0
    flakes: float = 0.0
