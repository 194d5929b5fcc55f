"""The tests of a module are found."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

HERE = Path(__file__).parent
_FILES = {
    "avsec_gym/__init__.py": "",
    "avsec_gym/road/__init__.py": "from avsec_gym.road.street import Street",
    "avsec_gym/road/street.py": "from avsec_gym.road.lane import width",
    "avsec_gym/road/lane.py": "",
    "avsec_gym/road/unused.py": "",
    "avsec_gym/games.py": 'ENTRY = "avsec_gym.game:Game"',
    "avsec_gym/game.py": "from avsec_gym.textures.library import load",
    "avsec_gym/textures/library.py": "load = importlib.import_module; NAMES = ['bark', 'games']",
    "avsec_gym/textures/bark.py": "",
    "tests/test_games.py": "from avsec_gym import games",
    "tests/road/test_lane.py": "from avsec_gym.road.lane import width",
    "tests/road/test_width.py": "from avsec_gym.road import Street",
    "tests/road/test_street_width.py": "from avsec_gym.road import Street",
}


@pytest.fixture
def which(tmp_path: Path) -> ModuleType:
    return _which(tmp_path, _FILES)


def _which(root: Path, files: dict[str, str] | None) -> ModuleType:
    spec = importlib.util.spec_from_file_location("which_of_test", HERE / "which.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for name, text in (files or {}).items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    vars(module)["ROOT"] = root
    return module


@pytest.mark.parametrize(
    ("module", "tests"),
    [
        (
            "road.lane",
            [
                (0, "tests/road/test_lane.py"),
                (2, "tests/road/test_street_width.py"),
                (2, "tests/road/test_width.py"),
            ],
        ),
        (
            "road.street",
            [(1, "tests/road/test_street_width.py"), (1, "tests/road/test_width.py")],
        ),
        ("game", [(2, "tests/test_games.py")]),
        ("textures.bark", [(4, "tests/test_games.py")]),
        ("road.unused", []),
    ],
)
def test_the_nearest_come_first(
    which: ModuleType, module: str, tests: list[tuple[int, str]]
) -> None:
    assert which.nearest_tests(f"avsec_gym.{module}") == tests


@pytest.mark.slow
def test_every_module_is_reached_by_a_test() -> None:
    which = _which(HERE.parent, None)
    assert not [module for module in which.modules() if not which.nearest_tests(module, most=1)]
