import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.world.textures import library
from avsec_gym.world.textures.library import TextureLibrary, texture_library
from avsec_gym.world.textures.noise import picture, white_noise
from avsec_gym.world.textures.texture import Texture

SIZES = {"plain": (1.0, 1.0), "bricks": (2.0, 1.0), "sand/0": (0.5, 0.5), "sand/1": (0.5, 0.5)}


def families() -> dict[str, Texture]:
    return {
        "plain": Texture((1.0, 1.0), 1, lambda _, __: np.full((4, 4, 3), 255, np.uint8)),
        "bricks": Texture((2.0, 1.0), 1, lambda _, rng: speckles(rng, 32, 64)),
        "sand": Texture((0.5, 0.5), 2, lambda _, rng: speckles(rng, 48, 48)),
    }


def speckles(rng: np.random.Generator, height: int, width: int) -> np.ndarray:
    return picture(128 + 40 * white_noise(rng, height, width)[..., None] * np.ones(3))


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, and few textures to draw."""
    monkeypatch.setenv("AVSEC_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(library, "_families", families)
    return tmp_path / "cache"


def load() -> TextureLibrary:
    """As a new process would."""
    return texture_library.__wrapped__()


def digest(loaded: TextureLibrary) -> str:
    code = hashlib.sha256("".join(loaded.names).encode())
    for array in loaded.arrays:
        code.update(np.ascontiguousarray(array).tobytes())
    return code.hexdigest()


def test_textures_are_found_by_name_with_their_pixels(cache: Path) -> None:
    loaded = load()
    assert set(loaded.names) == set(SIZES)
    arrays = loaded.arrays
    for name, size in SIZES.items():
        index = loaded.index(name)
        assert arrays.size[index].tolist() == pytest.approx(size)
        finest = library.draw(name)
        height, width = arrays.shape[index, 0]
        first = arrays.first[index, 0]
        np.testing.assert_array_equal(
            arrays.texels[first : first + height * width].reshape(height, width, 3), finest
        )
    with pytest.raises(KeyError):
        loaded.index("marble")


def test_every_level_is_half_as_fine_and_as_light_as_the_last(cache: Path) -> None:
    loaded = load()
    arrays = loaded.arrays
    for index in range(len(loaded.names)):
        light = []
        for level in range(arrays.levels[index]):
            height, width = arrays.shape[index, level]
            first = arrays.first[index, level]
            light.append(((arrays.texels[first : first + height * width] / 255.0) ** 2.2).mean())
            if level:
                np.testing.assert_array_equal(
                    arrays.shape[index, level], arrays.shape[index, level - 1] // 2
                )
        np.testing.assert_allclose(light, light[0], rtol=0.04)
        assert max(arrays.shape[index, arrays.levels[index] - 1]) <= 4


def test_variants_differ_and_redrawing_does_not(cache: Path) -> None:
    np.testing.assert_array_equal(library.draw("sand/1"), library.draw("sand/1"))
    assert not np.array_equal(library.draw("sand/0"), library.draw("sand/1"))


def test_the_cache_is_written_once_whole_and_read_again(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn = digest(load())
    files = {path: path.stat().st_mtime_ns for path in cache.iterdir()}
    assert {path.suffix for path in files} == {".npy", ".npz"}  # no partial file is left

    def no_families() -> dict[str, Texture]:
        return {name: Texture((1, 1), 1, refuse) for name in families()}

    def refuse(variant: int, rng: np.random.Generator) -> np.ndarray:
        raise AssertionError("drawn again")

    monkeypatch.setattr(library, "_families", no_families)
    assert digest(load()) == drawn
    assert {path: path.stat().st_mtime_ns for path in cache.iterdir()} == files


@pytest.mark.parametrize("suffix", [".npy", ".npz"])
@pytest.mark.parametrize("harm", ["empty", "cut", "short", "rubbish", "gone"])
def test_a_broken_cache_is_drawn_again(cache: Path, suffix: str, harm: str) -> None:
    drawn = digest(load())
    (path,) = cache.glob(f"*{suffix}")
    whole = path.read_bytes()
    if harm == "gone":
        path.unlink()
    else:
        path.write_bytes(
            {
                "empty": b"",
                "cut": whole[: len(whole) // 2],
                "short": whole[:-3],
                "rubbish": b"<html>" * 100,
            }[harm]
        )
    assert digest(load()) == drawn
    assert path.read_bytes()[:64] == whole[:64]
    assert digest(load()) == drawn


def test_tables_and_pixels_of_different_drawings_are_not_mixed(cache: Path) -> None:
    """As a process leaves it that was killed between the two files."""
    drawn = digest(load())
    (path,) = cache.glob("*.npy")
    np.save(path, np.load(path)[:-5])
    assert digest(load()) == drawn


def test_another_source_is_another_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    first = tmp_path / "one"
    first.mkdir()
    (first / "library.py").write_text("pass")
    (first / "walls.py").write_text("bricks = 3")
    monkeypatch.setattr(library, "__file__", str(first / "library.py"))
    before = library._fingerprint()
    assert library._fingerprint() == before
    (first / "walls.py").write_text("bricks = 4")
    assert library._fingerprint() != before


@pytest.mark.slow
def test_a_texture_does_not_depend_on_the_process() -> None:
    program = (
        "import hashlib; from avsec_gym.world.textures.library import draw;"
        "print(hashlib.sha256(draw('asphalt/0').tobytes()).hexdigest())"
    )
    found = set()
    for seed in ("1", "2"):
        run = subprocess.run(
            [sys.executable, "-c", program],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        )
        found.add(run.stdout.strip())
    assert found == {hashlib.sha256(library.draw("asphalt/0").tobytes()).hexdigest()}


def test_every_texture_has_a_size_and_names_are_unique() -> None:
    loaded = texture_library()
    assert len(set(loaded.names)) == len(loaded.names)
    assert (loaded.arrays.size > 0.02).all()
    assert (loaded.arrays.shape >= 1).all()
    last = loaded.arrays.first[:, 0] + loaded.arrays.shape[:, 0].prod(axis=-1)
    assert last.max() <= len(loaded.arrays.texels)
