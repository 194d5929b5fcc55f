"""Small data sets, made once, and a recipe that needs no rendering."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.rig import KITTI_CAMERAS, SensorRig, camera_rig
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.export import Sensors, make_data_set, suite_recipe


def small_rig() -> SensorRig:
    """KITTI's with a third of its pixels in each direction."""
    return camera_rig(
        KITTI_CAMERAS, focal_length=721.5377 / 3, centre=(202.9, 57.3), size=(414, 125)
    )


def contents(root: Path) -> dict[str, bytes]:
    """Every file of a folder."""
    return {
        path.relative_to(root).as_posix(): path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file()
    }


@pytest.fixture(scope="session")
def rig() -> SensorRig:
    return small_rig()


@pytest.fixture(scope="session")
def mixed(tmp_path_factory: pytest.TempPathFactory, rig: SensorRig) -> Path:
    """Two frames with one earlier frame each."""
    root = tmp_path_factory.mktemp("mixed")
    recipe = suite_recipe("mixed", 2, seed=1, sensors=Sensors(rig=rig), previous=1)
    make_data_set(recipe, root, workers=1)
    return root


@pytest.fixture(scope="session")
def raw(tmp_path_factory: pytest.TempPathFactory, rig: SensorRig) -> Path:
    """Four frames in two drives, of which the second is cut short."""
    root = tmp_path_factory.mktemp("raw")
    recipe = suite_recipe("raw", 4, seed=1, sensors=Sensors((0, 2, 3), rig=rig), drive_frames=3)
    make_data_set(recipe, root, workers=1)
    return root


@dataclass
class Texts:
    """Frames of two words."""

    count: int = 3
    word: str = "a"
    fails_at: int = -1
    error: BaseException | None = None
    made: list[int] = field(default_factory=list)
    last_files: str = "last/*.txt"

    @property
    def settings(self) -> dict[str, Any]:
        return {"suite": "texts", "word": self.word}

    def __len__(self) -> int:
        return self.count

    def last_file(self, number: int) -> str:
        return f"last/{number}.txt"

    def make(self, root: Path, number: int) -> list[str]:
        write_text(root / "first" / f"{number}.txt", self.word, overwrite=True)
        if number == self.fails_at:
            if self.error is None:
                return [f"{number} is left out"]
            raise self.error
        write_text(root / "last" / f"{number}.txt", self.word * number, overwrite=True)
        self.made.append(number)
        return []

    def finish(self, root: Path) -> None:
        names = sorted(path.name for path in (root / "last").iterdir())
        write_text(root / "list.txt", "\n".join(names), overwrite=True)
