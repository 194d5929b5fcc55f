"""All textures with their coarser levels in one flat buffer, made once and kept in the cache."""

from __future__ import annotations

import functools
import hashlib
import logging
import os
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import BinaryIO, NamedTuple

import cv2
import numpy as np
import platformdirs
from numpy.typing import NDArray

from avsec_gym.errors import DataError
from avsec_gym.storage.folders import make_folder
from avsec_gym.storage.npz_files import map_npy, read_npz
from avsec_gym.storage.regular_files import MAX_FILE_BYTES, read_bytes
from avsec_gym.storage.write_errors import naming
from avsec_gym.world.textures.noise import picture
from avsec_gym.world.textures.texture import Picture, Texture

FAMILIES = ("ground", "walls", "nature", "people", "cars", "vehicles", "street")
"""Modules beside this one; each has a dictionary `TEXTURES`."""

_AGAIN = "It is drawn anew."
_LOG = logging.getLogger(__name__)


class TextureArrays(NamedTuple):
    """T textures with up to L levels of detail, each half as fine as the last, for kernels."""

    texels: NDArray[np.uint8]
    """All pixels of all levels, shape (N, 3)."""
    first: NDArray[np.int64]
    """Where a level's pixels begin, shape (T, L)."""
    shape: NDArray[np.int32]
    """Height and width of a level, shape (T, L, 2)."""
    levels: NDArray[np.int32]
    """Number of levels, shape (T,)."""
    size: NDArray[np.float32]
    """Width and height of one repeat, metres, shape (T, 2)."""


@dataclass(frozen=True, eq=False)
class TextureLibrary:
    """All textures by name."""

    arrays: TextureArrays
    names: tuple[str, ...]

    @functools.cached_property
    def _numbers(self) -> dict[str, int]:
        numbers = {name: number for number, name in enumerate(self.names)}
        # A family's name alone stands for its first variant.
        for name, number in list(numbers.items()):
            numbers.setdefault(name.partition("/")[0], number)
        return numbers

    def index(self, name: str) -> int:
        """Where a texture is in the arrays.

        Raises:
            KeyError: There is no such texture.
        """
        return self._numbers[name]


@functools.cache
def texture_library() -> TextureLibrary:
    """The library, from the cache if it is there (a few milliseconds; else some seconds)."""
    families = _families()
    path = cache_folder() / f"textures-{_fingerprint()}.npz"
    texels_path = path.with_suffix(".npy")
    try:
        return _read(path, texels_path)
    except (DataError, KeyError, ValueError):
        # Not there yet, or broken: cut off by a full disk, for example.
        _LOG.info("drawing the textures, once")
        _draw_all(families, path, texels_path)
        return _read(path, texels_path)


def cache_folder() -> Path:
    """Where textures and default data sets are kept: ``AVSEC_CACHE``, or the user's cache."""
    given = os.environ.get("AVSEC_CACHE")
    return Path(given) if given else Path(platformdirs.user_cache_dir("avsec-gym"))


def draw(name: str) -> Picture:
    """One texture drawn anew, for looking at it.

    Raises:
        KeyError: There is no such texture.
    """
    family, _, variant = name.partition("/")
    texture = _families()[family]
    return texture.make(int(variant or 0), _generator(family, int(variant or 0)))


def _read(path: Path, texels_path: Path) -> TextureLibrary:
    texels = map_npy(texels_path, remedy=_AGAIN)
    table = read_npz(path, most=MAX_FILE_BYTES, remedy=_AGAIN)
    arrays = TextureArrays(texels, table["first"], table["shape"], table["levels"], table["size"])
    names = tuple(table["names"].tolist())
    if arrays.first[-1, -1] + arrays.shape[-1, -1].prod() != len(texels):
        raise ValueError("pixels and table belong to different drawings")
    return TextureLibrary(arrays, names)


def _families() -> dict[str, Texture]:
    every = {"plain": Texture((1.0, 1.0), 1, lambda _, __: np.full((4, 4, 3), 255, np.uint8))}
    for module in FAMILIES:
        every |= import_module(f"avsec_gym.world.textures.{module}").TEXTURES
    return every


def _generator(family: str, variant: int) -> np.random.Generator:
    key = int.from_bytes(hashlib.sha256(family.encode()).digest()[:8])
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence((key, variant))))


def _fingerprint() -> str:
    """Changes with any source that draws."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(read_bytes(path, most=MAX_FILE_BYTES))
    return digest.hexdigest()[:16]


def _draw_all(families: dict[str, Texture], path: Path, texels_path: Path) -> None:
    pixels: list[Picture] = []
    rows: list[list[tuple[int, int, int]]] = []
    names: list[str] = []
    sizes: list[tuple[float, float]] = []
    position = 0
    for family, texture in families.items():
        for variant in range(texture.variants):
            levels = []
            for level in _levels(texture.make(variant, _generator(family, variant))):
                height, width = level.shape[:2]
                levels.append((position, height, width))
                pixels.append(level.reshape(-1, 3))
                position += height * width
            rows.append(levels)
            names.append(family if texture.variants == 1 else f"{family}/{variant}")
            sizes.append(texture.size)
    deepest = max(map(len, rows))
    table = np.array([row + [row[-1]] * (deepest - len(row)) for row in rows])
    make_folder(path.parent)
    _save(texels_path, lambda file: np.save(file, np.concatenate(pixels)))
    _save(
        path,
        lambda file: np.savez(
            file,
            first=table[..., 0],
            shape=table[..., 1:].astype(np.int32),
            levels=np.array([len(row) for row in rows], np.int32),
            size=np.array(sizes, np.float32),
            names=np.array(names),
        ),
    )


def _levels(finest: Picture) -> list[Picture]:
    """The picture and its halves, averaged in linear light."""
    result = [finest]
    light: NDArray[np.float32] = (finest.astype(np.float32) / 255.0) ** 2.2
    while min(light.shape[:2]) > 1 and max(light.shape[:2]) > 4:
        size = (max(1, light.shape[1] // 2), max(1, light.shape[0] // 2))
        light = np.asarray(cv2.resize(light, size, interpolation=cv2.INTER_AREA), np.float32)
        result.append(picture(255.0 * light ** (1 / 2.2)))
    return result


def _save(path: Path, write: Callable[[BinaryIO], None]) -> None:
    """All or nothing, also when several processes draw at once."""
    with naming(path):
        handle, name = tempfile.mkstemp(dir=path.parent, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                write(file)
            os.chmod(name, 0o644)
            os.replace(name, path)
        except BaseException:
            os.unlink(name)
            raise
