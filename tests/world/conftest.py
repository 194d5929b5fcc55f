"""Small textures, cameras and scenes with known answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from avsec_gym.world.rendering import ray_scene, renderer
from avsec_gym.world.rendering.camera import PinholeCamera
from avsec_gym.world.textures.library import TextureArrays, TextureLibrary

Build = Callable[[Sequence[tuple[str, NDArray[np.uint8], tuple[float, float]]]], TextureLibrary]


@pytest.fixture(scope="session")
def build_library() -> Build:
    """Makes a library of pictures: name, picture (sides are powers of two), size in metres."""

    def build(
        pictures: Sequence[tuple[str, NDArray[np.uint8], tuple[float, float]]],
    ) -> TextureLibrary:
        texels, rows, position = [], [], 0
        for _, picture, _ in pictures:
            levels = []
            light = (picture / 255.0) ** 2.2
            while True:
                height, width = light.shape[:2]
                levels.append((position, height, width))
                texels.append((255.0 * light ** (1 / 2.2) + 0.5).astype(np.uint8).reshape(-1, 3))
                position += height * width
                if min(height, width) == 1:
                    break
                light = light.reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3))
            rows.append(levels)
        deepest = max(map(len, rows))
        table = np.array([row + [row[-1]] * (deepest - len(row)) for row in rows])
        texels = np.concatenate(texels)
        texels.flags.writeable = False  # like those that the real library maps
        arrays = TextureArrays(
            texels,
            np.ascontiguousarray(table[..., 0]),
            table[..., 1:].astype(np.int32),
            np.array([len(row) for row in rows], np.int32),
            np.array([size for *_, size in pictures], np.float32),
        )
        return TextureLibrary(arrays, tuple(name for name, *_ in pictures))

    return build


@pytest.fixture(scope="session")
def little_library(build_library: Build) -> TextureLibrary:
    """White (``plain``) and speckles of 5 cm (``speckles``)."""
    speckles = np.random.default_rng(0).normal(size=(256, 256)).astype(np.float32)
    speckles = cv2.GaussianBlur(np.tile(speckles, (3, 3)), (0, 0), 1.5)[256:512, 256:512]
    grey = np.clip(120 + 60 * speckles / speckles.std(), 0, 255).astype(np.uint8)
    return build_library(
        [
            ("plain", np.full((4, 4, 3), 255, np.uint8), (1.0, 1.0)),
            ("speckles", np.repeat(grey[..., None], 3, axis=2), (8.0, 8.0)),
        ]
    )


@pytest.fixture
def little_textures(monkeypatch: pytest.MonkeyPatch, little_library: TextureLibrary) -> None:
    """Scenes know only the little library: nothing has to be drawn, nothing depends on taste."""
    for module in (ray_scene, renderer):
        monkeypatch.setattr(module, "texture_library", lambda: little_library)


@pytest.fixture(scope="session")
def look() -> Callable[..., PinholeCamera]:
    """Makes a camera at a place that looks at another one."""

    def make(
        place: Sequence[float] = (0.0, 0.0, 1.65),
        target: Sequence[float] | None = None,
        *,
        focal_length: float = 100.0,
        size: tuple[int, int] = (160, 48),
        centre: tuple[float, float] | None = None,
    ) -> PinholeCamera:
        eye = np.asarray(place, float)
        forward = np.array([1.0, 0, 0]) if target is None else np.asarray(target, float) - eye
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, [0.0, 0.0, 1.0] if abs(forward[2]) < 0.99 else [0.0, 1.0, 0.0])
        right /= np.linalg.norm(right)
        to_world = np.eye(4)
        to_world[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
        to_world[:3, 3] = eye
        middle = centre or (0.5 * (size[0] - 1), 0.5 * (size[1] - 1))
        return PinholeCamera(to_world, focal_length, middle, size)

    return make
