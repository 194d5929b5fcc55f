"""Textures of street furniture: metal, concrete, rust, wood, cloth, and all that is printed."""

from __future__ import annotations

import cv2
import numpy as np

from avsec_gym.world.textures.noise import coloured, fractal_noise, picture, white_noise
from avsec_gym.world.textures.posters import POSTERS
from avsec_gym.world.textures.sign_faces import SIGN_FACES, sign_texture
from avsec_gym.world.textures.texture import Picture, Texture


def galvanised(_: int, rng: np.random.Generator) -> Picture:
    """Zinc on steel: patches of crystals, each with its own grey; 0.6 m."""
    size = 128
    places = rng.uniform(0, size, (160, 2))
    greys = rng.standard_normal(len(places)).astype(np.float32)
    y, x = np.mgrid[:size, :size]
    steps = np.abs(np.stack([y, x], -1)[:, :, None] - places)
    nearest = (np.minimum(steps, size - steps) ** 2).sum(-1).argmin(-1)
    clouds = fractal_noise(rng, size, size, cells=3, octaves=3)
    return picture(coloured((152, 157, 160), greys[nearest] + 0.7 * clouds, 0.03))


def cast_concrete(variant: int, rng: np.random.Generator) -> Picture:
    """Concrete from a mould, 4 m: seams of the boards, pores, dirt washed down from the top."""
    size = 512
    clouds = fractal_noise(rng, size, size, cells=4, persistence=0.6)
    # Water leaves streaks that fade on their way down.
    columns = fractal_noise(rng, size, size, cells=64, octaves=3)[:1]
    fade = np.linspace(1.0, 0.15, size, dtype=np.float32)[:, None]
    streaks = np.clip(columns - 0.3, 0, None) * fade
    pores = (white_noise(rng, size, size, 0.8) > 3.0).astype(np.float32)
    values = coloured(((168, 165, 157), (150, 150, 146))[variant], clouds, 0.06)
    values *= (1.0 - 0.16 * streaks - 0.25 * pores)[..., None]
    for seam in range(0, size, size // 4):
        values[seam : seam + 2] *= 0.86
        values[:, seam : seam + 2] *= 0.9
    return picture(values)


def rusty(_: int, rng: np.random.Generator) -> Picture:
    """Rusty steel, 1 m."""
    clouds = fractal_noise(rng, 128, 128, cells=6, persistence=0.65)
    return picture(
        coloured((118, 74, 50), clouds, 0.18) + 8.0 * white_noise(rng, 128, 128)[..., None]
    )


def raw_concrete(_: int, rng: np.random.Generator) -> Picture:
    """Concrete in small pieces, without seams: 1 m."""
    clouds = fractal_noise(rng, 128, 128, cells=3, persistence=0.6)
    grain = white_noise(rng, 128, 128, 0.6)
    return picture(coloured((158, 155, 148), clouds + 0.7 * grain, 0.05))


def weathered_wood(variant: int, rng: np.random.Generator) -> Picture:
    """Wood, 1 m: the grain runs along u in the first variant, along v in the second."""
    size = 256
    grain = fractal_noise(rng, size, size, cells=48, octaves=3)
    long = cv2.resize(grain[:, : size // 16], (size, size), interpolation=cv2.INTER_CUBIC)
    # The stretched grain meets its own mirror image at the edge.
    long = np.concatenate([long[:, ::2], long[:, ::-2]], axis=1)
    clouds = fractal_noise(rng, size, size, cells=3, octaves=3)
    wood = picture(coloured((128, 108, 86), 0.7 * long + 0.5 * clouds, 0.12))
    return wood if variant == 0 else np.ascontiguousarray(wood.transpose(1, 0, 2))


def ribbed(variant: int, rng: np.random.Generator) -> Picture:
    """A noise barrier's panels, 4 m by 1 m: aluminium ribs, or rough wood-concrete ones."""
    height, width = 128, 512
    y = np.arange(height, dtype=np.float32)[:, None]
    clouds = fractal_noise(rng, height, width, cells=6)
    if variant == 0:
        rib = np.cos(2.0 * np.pi * y / (height / 4)) + 0.0 * clouds
        values = coloured((214, 216, 214), 0.10 * rib + 0.03 * clouds, 1.0)
        values[: height // 64] *= 0.6
    else:
        x = np.arange(width, dtype=np.float32)[None, :]
        rib = np.clip(np.cos(2.0 * np.pi * x / (width / 32)) * 2.0, -1.0, 1.0) + 0.0 * y
        rough = white_noise(rng, height, width, 0.7)
        values = coloured((196, 186, 168), 0.14 * rib + 0.05 * clouds + 0.08 * rough, 1.0)
    values[:, : width // 256] *= 0.6
    return picture(values)


def cloth(_: int, rng: np.random.Generator) -> Picture:
    """Awning and parasol cloth, near white, 1 m."""
    folds = fractal_noise(rng, 128, 128, cells=3, octaves=3)
    weave = white_noise(rng, 128, 128)
    return picture(coloured((234, 233, 230), folds + 0.4 * weave, 0.025))


def banded(variant: int, _: np.random.Generator) -> Picture:
    """Warning bands: red and white, upright in the first variant, slanting in the second; 0.5 m."""
    size = 64
    y, x = np.mgrid[:size, :size]
    red = (x if variant == 0 else x + y) % size < size // 2
    return np.where(red[..., None], (172, 16, 22), (218, 218, 216)).astype(np.uint8)


def delineator(_: int, rng: np.random.Generator) -> Picture:
    """A delineator post's face, 0.12 m by 1.2 m: a slanting black band round a reflector."""
    height, width = 240, 24
    y, x = np.mgrid[:height, :width]
    values = coloured((236, 238, 238), fractal_noise(rng, height, width, cells=12), 0.02)
    slant = y - 0.35 * (width - x)
    values[(slant > 30) & (slant < 80)] = (24, 24, 26)
    values[(y > 42) & (y < 70) & (x > 8) & (x < 15)] = (244, 246, 246)
    # Splashed from the road.
    values *= (1.0 - 0.35 * np.clip((y - 150) / 90, 0, 1) ** 2)[..., None]
    return picture(values)


TEXTURES: dict[str, Texture] = {
    "galvanised": Texture((0.6, 0.6), 3, galvanised),
    "cast_concrete": Texture((4.0, 4.0), 2, cast_concrete),
    "rusty": Texture((1.0, 1.0), 3, rusty),
    "raw_concrete": Texture((1.0, 1.0), 3, raw_concrete),
    "weathered_wood": Texture((1.0, 1.0), 2, weathered_wood),
    "ribbed": Texture((4.0, 1.0), 2, ribbed),
    "cloth": Texture((1.0, 1.0), 3, cloth),
    "banded": Texture((0.5, 0.5), 2, banded),
    "delineator": Texture((0.12, 1.2), 1, delineator),
    **POSTERS,
    **{f"sign_{name}": sign_texture(face) for name, face in SIGN_FACES.items()},
}
