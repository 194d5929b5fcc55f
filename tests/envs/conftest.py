"""For attackers on images: small frames, and a quick detector that every process knows by name."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
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
    """Arguments of an attack on images that is played in milliseconds."""
    return dict(json.loads(os.environ[ARGUMENTS]))
