"""Frames of the procedural world in which a car is in the way, for attackers that hide cars.

In nine of ten situations of the suite `mixed` a car that sees nothing drives as safely as one that
sees all: whoever hides objects plays for nothing there.  Layouts show which ones these are before
anything is rendered.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count, islice
from pathlib import Path
from typing import Any

from avsec_gym.boxes import Boxes3D
from avsec_gym.pipeline import run_episode
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.world.export.data_set import Progress
from avsec_gym.world.export.default_suites import cached
from avsec_gym.world.export.suites import LayoutFrames
from avsec_gym.world.layouts import generate_layout


@dataclass(frozen=True, eq=False)
class ContestedFrames(LayoutFrames):
    """Those of a suite's frames whose numbers are given."""

    numbers: tuple[int, ...] = ()

    @property
    def settings(self) -> dict[str, Any]:
        return super().settings | {"chosen": "contested"}

    def last_file(self, number: int) -> str:
        return super().last_file(self.numbers[number])

    def make(self, root: Path, number: int) -> list[str]:
        return super().make(root, self.numbers[number])


def contested_frames(frames: int, seed: int, on_progress: Progress) -> Path:
    """A folder in KITTI's object layout, with scans; rendered into the cache on first use.

    Args:
        frames: How many.
        seed: Of the set of layouts; those that the package's networks know are below 1000.
        on_progress: Called after every frame.
    """
    numbers = tuple(islice((n for n in count() if is_contested(n, seed)), frames))
    recipe = ContestedFrames("mixed", frames, seed, numbers=numbers)
    return cached(f"contested-{seed}-{frames}", recipe, on_progress=on_progress)


def is_contested(number: int, seed: int) -> bool:
    """Whether, with some intention, a car that sees all drives safely, and a blind one does not."""
    layout = generate_layout(number, set_seed=seed)
    scene = Scene(layout.id, layout.boxes, layout.road_type, number=number)
    return any(
        run_episode(scene, intention, motion=Motion.STATIC).record.safe
        and not run_episode(scene, intention, Boxes3D.empty(), motion=Motion.STATIC).record.safe
        for intention in Intention
    )
