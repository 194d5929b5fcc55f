"""What people wear and carry, chosen by a number."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from avsec_gym.world.assets import part_of, variants
from avsec_gym.world.material import Material
from avsec_gym.world.textures.people import HEADS, Colour

_FEMININE = ("long", "bob", "ponytail", "bun")

_DARK: tuple[Colour, ...] = (
    (48, 48, 52), (50, 56, 76), (66, 68, 74), (62, 54, 50), (48, 62, 58), (76, 50, 52),
)  # fmt: skip
_MUTED: tuple[Colour, ...] = (
    (112, 114, 118), (146, 138, 122), (92, 98, 84), (84, 104, 132), (122, 88, 72), (104, 84, 96),
    (168, 162, 150), (66, 84, 112),
)  # fmt: skip
_LIGHT: tuple[Colour, ...] = (
    (236, 236, 232), (214, 206, 190), (196, 208, 222), (226, 216, 206), (222, 224, 226),
)  # fmt: skip
_STRONG: tuple[Colour, ...] = (
    (142, 40, 40), (54, 76, 120), (58, 92, 72), (178, 128, 70), (124, 62, 82), (78, 120, 136),
)  # fmt: skip
_JEANS: tuple[Colour, ...] = ((64, 72, 90), (90, 100, 118), (56, 62, 76), (128, 136, 148))


@dataclass(frozen=True)
class Outfit:
    """Clothes, hair and luggage of one person.

    Args:
        style: Style of the hair, see `HeadLook`.
        feminine: Narrower waist and shoulders, wider hips.
        stout: Added to the girth of the trunk, as a share.
        head: Material of the head, with the face on it.
        hair: Material of hair that stands off the head.
        skin: Material of hands, and of bare arms and legs.
        top: Shirt, pullover or coat.
        inner: Shows where the top is open in front.
        sleeve: End of the sleeves: 0 the shoulder, 1 the elbow, 2 the wrist.
        hem: End of the top, in body heights above the hip joints.
        bulk: Thickness of the top, in body heights.
        is_open: The top is a jacket that is open in front.
        legs: Trousers, shorts, stockings.
        trouser_end: End of the trousers: 1 the knee, 2 the ankle.
        loose: Width of the trousers relative to the leg.
        skirt: The lower edge in body heights above the hip joints; None for trousers.
        lower: Material of the skirt, which may belong to a dress.
        shoes: Material of the shoes' upper side.
        soles: Material of the soles and of what they stand on.
        hat: Kind of hat: none, cap, hat, helmet, hood.
        headgear: Material of the hat.
        luggage: Kind of luggage: none, backpack, shoulder bag, handbag, shopping bag.
        bag: Material of the luggage.
        side: The hand that carries: 0 right, 1 left.
    """

    style: str
    feminine: bool
    stout: float
    head: Material
    hair: Material
    skin: Material
    top: Material
    inner: Material
    sleeve: float
    hem: float
    bulk: float
    is_open: bool
    legs: Material
    trouser_end: float
    loose: float
    skirt: float | None
    lower: Material
    shoes: Material
    soles: Material
    hat: str
    headgear: Material
    luggage: str
    bag: Material
    side: int


@functools.lru_cache(maxsize=512)
def dressed(appearance: int, height: float = 1.76, *, seated: bool = False) -> Outfit:
    """The outfit that belongs to a number.

    Args:
        appearance: Number of the outfit, 0 or more.
        height: Height of the person, metres; children wear children's clothes.
        seated: Whether the person sits: without luggage, skirts and coats, which would hinder.
    """
    rng = np.random.Generator(np.random.PCG64(appearance))
    # The head first: the other clothes suit it.
    child = height < 1.45
    looks = [n for n, look in enumerate(HEADS) if not (child and _grown_up(n))]
    held = variants("texture/head", len(HEADS), part_of(appearance))
    look = int(rng.choice([n for n in looks if n in held]))
    feminine = HEADS[look].style in _FEMININE
    top, inner, sleeve, hem, bulk, is_open = _top(rng, feminine, seated)
    legs, trouser_end, loose = _trousers(rng, feminine)
    # A skirt in place of trousers; half of them belong to a dress.
    skirt, lower = None, top
    if feminine and not seated and rng.random() < 0.30:
        skirt = float(rng.choice([-0.17, -0.24, -0.40]))
        if rng.random() < 0.5:
            lower = fabric("fabric/1", _pick(rng, _DARK, _MUTED, _STRONG))
        hem = max(hem, -0.03)
        legs = fabric("fabric/0", (48, 46, 48)) if rng.random() < 0.4 else bare(HEADS[look].skin)
        trouser_end, loose = 2.0, 0.74
    shoes, soles = _shoes(rng)
    return Outfit(
        HEADS[look].style,
        feminine,
        float(np.clip(0.14 * rng.standard_normal() + 0.02, 0.0, 0.25)) * (not child),
        Material(f"head/{look}", infrared=0.5),
        fabric("hair", HEADS[look].hair, 0.4),
        bare(HEADS[look].skin),
        top,
        inner,
        sleeve,
        hem,
        bulk,
        is_open,
        legs,
        trouser_end,
        loose,
        skirt,
        lower,
        shoes,
        soles,
        *_hat(rng, HEADS[look].style),
        *_luggage(rng, feminine, child, seated),
        int(rng.integers(2)),
    )


def fabric(texture: str, colour: Colour, infrared: float | None = None) -> Material:
    """Cloth of a colour; dark cloth is brighter in the infrared than to the eye."""
    red, green, blue = ((value / 255.0) ** 2.2 for value in colour)
    if infrared is None:
        infrared = round(min(0.8, 0.42 + 0.4 * (red + green + blue) / 3.0), 3)
    return Material(texture, (red, green, blue), infrared=infrared)


def bare(colour: Colour) -> Material:
    """Skin of a colour."""
    return fabric("skin", colour, 0.5)


def _grown_up(look: int) -> bool:
    head = HEADS[look]
    return head.beard or bool(head.glasses) or head.style in ("receding", "bald")


def _pick(rng: np.random.Generator, *families: tuple[Colour, ...]) -> Colour:
    family = families[rng.integers(len(families))]
    return family[rng.integers(len(family))]


def _top(
    rng: np.random.Generator, feminine: bool, seated: bool
) -> tuple[Material, Material, float, float, float, bool]:
    kinds = ("t-shirt", "shirt", "jumper", "jacket", "coat")
    weights = (0.30, 0.20, 0.18, 0.27, 0.05)
    kind = kinds[rng.choice(len(kinds), p=weights)]
    inner = fabric("fabric/0", _pick(rng, _LIGHT, _DARK, _MUTED))
    if kind == "t-shirt":
        textures = ["fabric/0", "fabric/1", "stripes/0", "stripes/2"]
        texture = str(rng.choice(textures, p=(0.5, 0.3, 0.1, 0.1)))
        colour = _pick(rng, _LIGHT, _DARK, _DARK, _STRONG, _MUTED, _MUTED)
        sleeve = 0.25 if feminine else 0.72
        return fabric(texture, colour), inner, sleeve, -0.015, 0.003, False
    if kind == "shirt":
        textures = ["fabric/1", "checks/0", "checks/1", "stripes/1"]
        texture = str(rng.choice(textures, p=(0.6, 0.15, 0.15, 0.1)))
        sleeve = 1.25 if rng.random() < 0.3 else 1.98
        material = fabric(texture, _pick(rng, _LIGHT, _LIGHT, _MUTED))
        return material, inner, sleeve, -0.03, 0.004, False
    if kind == "jumper":
        colour = _pick(rng, _DARK, _MUTED, _STRONG)
        return fabric(f"knit/{rng.integers(2)}", colour), inner, 2.0, -0.02, 0.008, False
    is_open = bool(rng.random() < 0.5) and not seated
    material = fabric(f"fabric/{rng.integers(1, 3)}", _pick(rng, _DARK, _DARK, _MUTED, _LIGHT))
    hem = -0.04 if kind == "jacket" or seated else -0.19
    return material, inner, 2.03, hem, 0.012, is_open


def _trousers(rng: np.random.Generator, feminine: bool) -> tuple[Material, float, float]:
    if rng.random() < 0.14:
        return fabric("fabric/1", _pick(rng, _DARK, _MUTED, _LIGHT)), 0.9, 1.15
    loose = 0.90 if feminine else 1.02 + 0.1 * float(rng.random())
    if rng.random() < 0.55:
        return fabric(f"denim/{rng.integers(2)}", _JEANS[rng.integers(len(_JEANS))]), 2.08, loose
    return fabric("fabric/2", _pick(rng, _DARK, _DARK, _MUTED, _LIGHT)), 2.08, loose


def _shoes(rng: np.random.Generator) -> tuple[Material, Material]:
    dark, brown, white = (44, 42, 42), (74, 52, 38), (214, 214, 210)
    upper = (dark, dark, brown, white, (96, 98, 104))[rng.integers(5)]
    sole = white if upper != brown and rng.random() < 0.45 else (40, 38, 38)
    return fabric("leather", upper, 0.4), fabric("leather", sole, 0.4)


def _hat(rng: np.random.Generator, style: str) -> tuple[str, Material]:
    chance = rng.random()
    hat = "cap" if chance < 0.09 else "hat" if chance > 0.95 else "none"
    if style in _FEMININE:
        hat = "none"
    return hat, fabric("fabric/0", _pick(rng, _DARK, _MUTED, _LIGHT, _STRONG))


def _luggage(
    rng: np.random.Generator, feminine: bool, child: bool, seated: bool
) -> tuple[str, Material]:
    names = ("none", "backpack", "shoulder bag", "handbag", "shopping bag")
    shares = (0.52, 0.18, 0.14, 0.08, 0.08) if not feminine else (0.40, 0.10, 0.20, 0.22, 0.08)
    name = names[rng.choice(len(names), p=shares)]
    if (child or seated) and name != "backpack":
        name = "none"
    texture = "leather" if name == "handbag" else "fabric/0"
    return name, fabric(texture, _pick(rng, _DARK, _DARK, _MUTED, _STRONG))
