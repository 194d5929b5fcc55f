"""Measurements of rendered frames: each made once, kept and resumed, by several workers."""

from __future__ import annotations

import hashlib
import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, TypeVar, get_type_hints

import numpy as np

from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.progress import Progress
from avsec_gym.road_type import RoadType
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.capture import Capture, Lidar, render
from avsec_gym.world.export import (
    cache_folder,
    make_data_set,
    twin_rig,
    world_fingerprint,
)
from avsec_gym.world.layouts import generate_layout
from avsec_gym.world.posed_scenes import PosedScene, posed_scene_of_labels, posed_scene_of_layout

SUITES = {"street": RoadType.STREET, "highway": RoadType.HIGHWAY, "mixed": None}
"""The suites whose frames are layouts, and their road type."""

Measure = Callable[[PosedScene, Capture], object]
"""Takes a scene and what the sensors deliver of it; returns a row, a dataclass that its annotation
names.  A function of a module, whose name is the row's key in the files."""
Row = TypeVar("Row")


class Scenes(Protocol):
    """Scenes by number; travels to worker processes."""

    @property
    def settings(self) -> dict[str, Any]:
        """JSON-able: all that decides what they are."""

    def posed_scene(self, number: int) -> PosedScene:
        """One of them."""


@dataclass(frozen=True)
class SuiteScenes:
    """The scenes of a suite, see `avsec_gym.world.export`."""

    suite: str = "mixed"
    seed: int = 0

    @property
    def settings(self) -> dict[str, Any]:
        """See `Scenes`."""
        return {"suite": self.suite, "seed": self.seed}

    def posed_scene(self, number: int) -> PosedScene:
        """See `Scenes`."""
        return posed_scene_of_layout(
            generate_layout(number, SUITES[self.suite], set_seed=self.seed)
        )


@dataclass(frozen=True)
class TwinScenes:
    """Twins of labelled real frames."""

    kitti: Path
    ids: tuple[str, ...]
    seed: int = 0

    @property
    def settings(self) -> dict[str, Any]:
        """See `Scenes`."""
        ids = hashlib.sha256(" ".join(self.ids).encode()).hexdigest()[:12]
        return {"suite": "twin", "seed": self.seed, "ids": ids}

    def posed_scene(self, number: int) -> PosedScene:
        """See `Scenes`."""
        id, data = self.ids[number], KittiObject(self.kitti)
        boxes = data.labels(id)
        return posed_scene_of_labels(
            boxes, twin_rig(data, id, boxes), seed=self.seed * 1_000_000 + number
        )


@dataclass(frozen=True)
class MeasuredFrames:
    """A row of measurements for each scene; a `Recipe`.

    Args:
        scenes: What is measured.
        count: How many of them.
        measures: What is measured of each.
        images: Whether images and scans are needed; labels and geometry are always there.
    """

    scenes: Scenes
    count: int
    measures: tuple[Measure, ...]
    images: bool = True
    last_files: str = field(default="*.json", init=False)

    @property
    def settings(self) -> dict[str, Any]:
        """See `Recipe`; the measuring code is a part of them."""
        sources = [inspect.getsource(inspect.getmodule(each) or each) for each in self.measures]
        return {
            **self.scenes.settings,
            "images": self.images,
            "measures": [name_of(each) for each in self.measures],
            "code": hashlib.sha256("".join(sources).encode()).hexdigest()[:12],
        }

    def __len__(self) -> int:
        return self.count

    def last_file(self, number: int) -> str:
        """See `Recipe`."""
        return f"{number:06d}.json"

    def make(self, root: Path, number: int) -> list[str]:
        """See `Recipe`."""
        posed = self.scenes.posed_scene(number)
        capture = (
            render(posed, cameras=(2, 3), lidar=Lidar())
            if self.images
            else render(posed, cameras=(), lidar=None)
        )
        row = {name_of(each): row_json(each(posed, capture)) for each in self.measures}
        write_text(root / self.last_file(number), json.dumps(row, allow_nan=False) + "\n")
        return []

    def finish(self, root: Path) -> None:
        """See `Recipe`."""


def name_of(measure: Measure) -> str:
    """The key of a measure: its file's name, which stays when the module runs as a script."""
    return Path(inspect.getfile(measure)).stem


@dataclass(frozen=True)
class MeasuredRows:
    """The files of `MeasuredFrames`, read."""

    files: Sequence[Mapping[str, Mapping[str, Any]]]
    """The rows, for each frame, of its measures, by their names."""

    def of(self, measure: Callable[[PosedScene, Capture], Row]) -> list[Row]:
        """The rows of one measure, frame by frame."""
        kind: type[Row] = get_type_hints(measure)["return"]
        return [row_of(kind, rows[name_of(measure)]) for rows in self.files]


def measured(
    recipe: MeasuredFrames,
    *,
    workers: int | None = None,
    rows: Path | None = None,
    on_progress: Progress | None = None,
) -> MeasuredRows:
    """Every measure's rows; what is there already is not measured again.

    Args:
        recipe: What to measure.
        workers: The number of processes; two if None.
        rows: The folder that keeps the rows, one for each recipe; in the user's cache if None.
        on_progress: Function that gets frames done and frames in all.

    Raises:
        DataError: The folder cannot be written, or holds other measurements.
    """
    settings = json.dumps(recipe.settings, sort_keys=True) + world_fingerprint()
    key = hashlib.sha256(settings.encode()).hexdigest()[:16]
    root = (cache_folder() / "measurements" if rows is None else rows) / key
    make_data_set(recipe, root, workers=workers, on_progress=on_progress)
    return MeasuredRows(
        [
            read_json_object(root / recipe.last_file(i), remedy="Remove it: it is made anew.")
            for i in range(len(recipe))
        ]
    )


@dataclass(frozen=True)
class Percentiles:
    """Mean and percentiles of what is known; None where nothing is."""

    mean: float | None = None
    p5: float | None = None
    p25: float | None = None
    p50: float | None = None
    p75: float | None = None
    p95: float | None = None


def quantiles(values: Sequence[float | None]) -> Percentiles:
    """The spread of the values that are known."""
    known = [value for value in values if value is not None]
    if not known:
        return Percentiles()
    return Percentiles(
        float(np.mean(known)), *map(float, np.percentile(known, [5, 25, 50, 75, 95]))
    )
