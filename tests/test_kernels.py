"""Compiled kernels are those of today's sources, whatever was compiled before."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

import avsec_gym
from avsec_gym.kernels import sources_of

PACKAGE = Path(avsec_gym.__file__).parent
SOURCES = {path: path.read_text() for path in PACKAGE.rglob("*.py")}
WITH_KERNELS = sorted(path for path, text in SOURCES.items() if "@kernel(" in text)

FILES = {
    "__init__.py": "",
    "places.py": "from typing import NamedTuple\n\nclass Place(NamedTuple):\n    x: float\n"
    "    y: float\n",
    "factor.py": "FACTOR = 2.0\n",
    "inner.py": "from avsec_gym.factor import FACTOR\nfrom avsec_gym.kernels import kernel\n"
    "from avsec_gym.places import Place\n\n@kernel()\ndef inner(place: Place) -> float:\n"
    "    return FACTOR * place.x\n",
    "outer.py": "from avsec_gym.inner import inner\nfrom avsec_gym.kernels import kernel\n"
    "from avsec_gym.places import Place\n\n@kernel()\ndef outer(place: Place) -> float:\n"
    "    return inner(place) + 1.0\n",
    "other.py": "OTHER = 1\n",
}
CALL = (
    "from avsec_gym import outer, places\n"
    "place = next(v for k, v in vars(places).items() if k.startswith('Place'))\n"
    "print(outer.outer(place(3.0, 5.0)), sum(outer.outer.stats.cache_hits.values()))\n"
)


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A small package of this one's name, with its kernels' decorator."""
    folder = tmp_path / "avsec_gym"
    folder.mkdir()
    for name, text in FILES.items():
        (folder / name).write_text(text)
    shutil.copy(PACKAGE / "kernels.py", folder)
    return folder


def called(package: Path, **environment: str) -> tuple[float, int]:
    """What the outer kernel returns, in a new process, and how many versions it found on disk."""
    known = {**os.environ, "PYTHONPATH": str(package.parent), "HOME": str(package.parent)}
    known = {k: v for k, v in known.items() if k not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")}
    done = subprocess.run(
        [sys.executable, "-c", CALL], env=known | environment, capture_output=True, text=True,
        timeout=300, cwd=package.parent,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    value, found = done.stdout.split()
    return float(value), int(found)


def change(package: Path, name: str, old: str, new: str) -> None:
    path = package / name
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))


@pytest.mark.slow
def test_kernels_are_kept_until_a_source_changes(package: Path) -> None:
    assert called(package) == (7.0, 0)
    assert called(package) == (7.0, 1)
    change(package, "other.py", "1", "2")
    assert called(package) == (7.0, 1)
    # A constant that only the inner one reads; numba by itself still answers 7.
    change(package, "factor.py", "2.0", "4.0")
    assert called(package) == (13.0, 0)
    # The fields change places.
    change(package, "places.py", "    x: float\n    y: float\n", "    y: float\n    x: float\n")
    assert called(package) == (21.0, 0)


@pytest.mark.slow
def test_a_type_has_another_name(package: Path) -> None:
    """By itself, numba ends in an AttributeError as it reads what it has kept."""
    assert called(package) == (7.0, 0)
    for name in ("places.py", "inner.py", "outer.py"):
        text = (package / name).read_text()
        (package / name).write_text(text.replace("import Place", "import Places").replace(
            ": Place)", ": Places)").replace("class Place(", "class Places("))  # fmt: skip
    assert called(package) == (7.0, 0)
    assert called(package) == (7.0, 1)


@pytest.mark.slow
def test_few_folders_of_earlier_sources_are_kept(package: Path) -> None:
    for number in range(6):
        (package / "factor.py").write_text(f"FACTOR = {number}.0\n")
        assert called(package) == (3.0 * number + 1.0, 0)
    folders = sorted(path.name for path in (package / "__pycache__" / "kernels").iterdir())
    assert [name.split("-")[0] for name in folders] == ["inner"] * 4 + ["outer"] * 4


@pytest.mark.slow
def test_the_user_s_place_and_places_that_cannot_be_written(package: Path) -> None:
    mine = package.parent / "mine"
    assert called(package, NUMBA_CACHE_DIR=str(mine)) == (7.0, 0)
    assert called(package, NUMBA_CACHE_DIR=str(mine)) == (7.0, 1)
    assert not (package / "__pycache__" / "kernels").exists()
    # Files stand where folders are to be, which stops the superuser, too.
    (package / "__pycache__").mkdir(exist_ok=True)
    (package / "__pycache__" / "kernels").write_text("")
    shutil.rmtree(package.parent / ".cache", ignore_errors=True)
    (package.parent / ".cache").write_text("")
    temporary = package.parent / "temporary"
    temporary.mkdir()
    assert called(package, TMPDIR=str(temporary)) == (7.0, 0)
    assert any(temporary.rglob("*.nbi"))


def test_no_kept_kernel_is_for_a_type_of_the_tests() -> None:
    """A process that cannot import it could not read what is kept for all others."""
    kept = []
    for path in PACKAGE.rglob("*.nbi"):
        with suppress(FileNotFoundError):  # Other tests remove what is too old.
            if b"tests." in path.read_bytes():
                kept.append(path.parent)
    assert not kept, f"remove these folders, and hand no such type to a kernel: {kept}"


def test_every_kernel_is_made_by_the_decorator() -> None:
    assert len(WITH_KERNELS) > 30
    for path, text in SOURCES.items():
        assert "njit" not in text or path.name == "kernels.py", path


@pytest.mark.parametrize("path", WITH_KERNELS, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_sources_are_all_that_a_kernel_s_file_imports(path: Path) -> None:
    """Found by patterns, as it has to be fast; here by a parser."""
    found, waiting = {path}, [path]
    while waiting:
        for node in ast.walk(ast.parse(waiting.pop().read_text())):
            assert not (isinstance(node, ast.ImportFrom) and node.level), "an import of `.`"
            if isinstance(node, ast.Import):
                assert not any(each.name.startswith("avsec_gym.") for each in node.names), path
            if not (isinstance(node, ast.ImportFrom) and node.module):
                continue
            parts = node.module.split(".")
            if parts[0] != "avsec_gym":
                continue
            place = PACKAGE.joinpath(*parts[1:])
            for each in (place, *(place / alias.name for alias in node.names)):
                for file in (each.with_suffix(".py"), each / "__init__.py"):
                    if file.is_file() and file not in found:
                        found.add(file)
                        waiting.append(file)
    assert sources_of(path) == found
