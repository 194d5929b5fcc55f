"""For attackers on sensors: small frames, and a quick detector that every process knows by name."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

ARGUMENTS = "IMAGE_ATTACK_ARGUMENTS"
"""Environment variable: what `gym.make` gets, as JSON."""


@pytest.fixture(scope="session", autouse=True)
def bright_cars(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ModuleType]:
    """The plug-in, installed as a package's entry point would be, and its frames."""
    root = tmp_path_factory.mktemp("bright_cars")
    package = root / "bright_cars-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: bright_cars\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text(
        "[avsec_gym.plugins]\nbright_cars = bright_cars:register_detector\n"
    )
    here = Path(__file__).parent
    with pytest.MonkeyPatch.context() as patched:
        patched.syspath_prepend(here)
        patched.syspath_prepend(root)
        path = os.pathsep.join(filter(None, [str(here), str(root), os.environ.get("PYTHONPATH")]))
        patched.setenv("PYTHONPATH", path)
        import bright_cars

        bright_cars.register_detector()
        bright_cars.write_frames(root)
        patched.setenv(ARGUMENTS, json.dumps({"scenarios": str(root), "detector": "bright_cars"}))
        yield bright_cars


@pytest.fixture
def quick() -> dict[str, Any]:
    """Arguments of an attack on sensors that is played in milliseconds."""
    return dict(json.loads(os.environ[ARGUMENTS]))


@pytest.fixture
def watched(quick: dict[str, Any], bright_cars: ModuleType) -> dict[str, Any]:
    """The same with frames for the thresholds of a validator, which are not played."""
    return quick | {"clean": str(Path(quick["scenarios"]) / bright_cars.CLEAN)}


@pytest.fixture(scope="session")
def small_cache(tmp_path_factory: pytest.TempPathFactory, bright_cars: ModuleType) -> Path:
    """A cache whose default suites `mixed`, `raw` and `connected` have a few small frames each.

    One for all of xdist's workers.
    """
    from avsec_gym.world.export import Sensors, default_suites, suite_recipe
    from avsec_gym.world.textures.library import cache_folder, texture_library

    own = tmp_path_factory.getbasetemp()
    cache = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "small_cache"
    cache.mkdir(exist_ok=True)
    texture_library()
    for path in cache_folder().glob("textures-*"):
        with suppress(FileExistsError):
            (cache / path.name).symlink_to(path)
    recipe = suite_recipe("mixed", 6, sensors=Sensors((2, 3), rig=bright_cars.rig()), previous=0)
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("AVSEC_CACHE", str(cache))
        default_suites.cached("mixed", recipe, 1)
        sensors = Sensors(rig=bright_cars.rig())
        drives = suite_recipe("raw", 4, sensors=sensors, previous=0, drive_frames=2)
        default_suites.cached("raw", drives, 1)
        sensors = Sensors((2,), rig=bright_cars.rig())
        default_suites.cached("connected", suite_recipe("connected", 3, sensors=sensors), 1)
    return cache


@pytest.fixture(scope="module")
def small_suite(small_cache: Path) -> Iterator[None]:
    """The default suite is small: making the real one takes minutes."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("AVSEC_CACHE", str(small_cache))
        yield
