"""Textures of the part that a place or an actor belongs to; see `avsec_gym.world.assets`."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from functools import cache, lru_cache

from avsec_gym.world.assets import Assets, part_of, shared, variants
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.textures.library import texture_library

_LIKE = {"stucco_foot": "stucco"}
"""Families whose variants belong to those of another one."""


def with_chosen_textures(mesh: Mesh, seed: int) -> Mesh:
    """The mesh with textures of the part of a seed.

    A model names a texture (``slate``), or the very variant that it would like (``stucco/2``).
    What is not of the part gives way to a variant of the same family that is.

    Args:
        mesh: The mesh of a model.
        seed: Seed of the place or of the actor; among equals it chooses.
    """
    part = part_of(seed)
    names = [chosen_texture(each.texture, part, seed) for each in mesh.materials]
    if all(each.texture == name for each, name in zip(mesh.materials, names, strict=True)):
        return mesh
    materials = (
        each if each.texture == name else replace(each, texture=name)
        for each, name in zip(mesh.materials, names, strict=True)
    )
    return replace(mesh, materials=tuple(materials))


@lru_cache(maxsize=8192)
def chosen_texture(name: str, part: Assets, seed: int) -> str:
    """The name of a texture of the library: this one if the part has it, else one like it."""
    family, _, variant = name.partition("/")
    count = family_sizes().get(family, 1)
    if count == 1 or shared(family):
        return name
    choices = variants(f"texture/{_LIKE.get(family, family)}", count, part)
    if variant and int(variant) in choices:
        return name
    return f"{family}/{choices[(int(variant) if variant else seed) % len(choices)]}"


@cache
def family_sizes() -> dict[str, int]:
    """Number of variants of each family of textures."""
    return dict(Counter(name.partition("/")[0] for name in texture_library().names))
