"""Measurements of procedural frames: made once for each frame, kept, resumed, by many workers."""

from __future__ import annotations

import argparse
import hashlib
import inspect
import json
import logging
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.errors import AvsecError
from avsec_gym.kitti.text_files import read_text, write_text
from avsec_gym.road_type import RoadType
from avsec_gym.world.capture import Capture, take
from avsec_gym.world.export.data_set import make_data_set
from avsec_gym.world.export.manifest import world_fingerprint
from avsec_gym.world.layouts import generate_layout
from avsec_gym.world.rendering.lidar import Lidar
from avsec_gym.world.shots import Shot, shot_of_layout
from avsec_gym.world.textures.library import cache_folder

Measure = Callable[[Shot, Capture], dict[str, Any]]
"""Takes a scene and what the sensors delivered of it; returns something JSON-able."""

_SUITES = {"street": RoadType.STREET, "highway": RoadType.HIGHWAY, "mixed": None}
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True)
class MeasuredFrames:
    """A row of measurements for each frame of a suite; see `Recipe`.

    Args:
        measures: Functions of modules; their modules' names are the keys of the rows.
        count: Of frames.
        suite: ``mixed``, ``street`` or ``highway``.
        seed: Of the suite.
        images: Whether cameras 2 and 3 and the LiDAR are needed; labels and depth always are.
    """

    measures: tuple[Measure, ...]
    count: int
    suite: str = "mixed"
    seed: int = 0
    images: bool = True
    last_files: str = field(default="*.json", init=False)

    @property
    def settings(self) -> dict[str, Any]:
        """See `Recipe`; the measuring code is a part of them."""
        sources = [inspect.getsource(inspect.getmodule(each) or each) for each in self.measures]
        return {
            "suite": self.suite,
            "seed": self.seed,
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
        layout = generate_layout(number, _SUITES[self.suite], set_seed=self.seed)
        shot = shot_of_layout(layout)
        cameras, lidar = ((2, 3), Lidar()) if self.images else ((), None)
        capture = take(shot, cameras=cameras, lidar=lidar)
        row = {name_of(measure): measure(shot, capture) for measure in self.measures}
        write_text(root / self.last_file(number), json.dumps(row, allow_nan=False) + "\n")
        return []

    def finish(self, root: Path) -> None:
        """See `Recipe`."""


def name_of(measure: Measure) -> str:
    """A measure's key: its module's last name."""
    return measure.__module__.rpartition(".")[2]


def measured(
    recipe: MeasuredFrames, root: Path | None = None, workers: int | None = None
) -> list[dict[str, Any]]:
    """The rows of all frames; those that are there are not made again.

    Args:
        recipe: What to measure.
        root: Where the rows are kept; the user's cache if None.
        workers: Processes.

    Raises:
        DataError: The folder cannot be written, or holds other measurements.
    """
    settings = recipe.settings
    if root is None:
        name = f"{recipe.suite}-{recipe.seed}-{settings['code']}-{world_fingerprint()}"
        root = cache_folder() / "measurements" / name
    make_data_set(recipe, root, workers=workers, on_progress=_progress())
    return [json.loads(read_text(root / recipe.last_file(i))) for i in range(len(recipe))]


def rows_of(measure: Measure, options: argparse.Namespace) -> list[dict[str, Any]]:
    """The rows of one measure, as the options of `command` ask for them."""
    recipe = MeasuredFrames((measure,), options.frames, options.suite, options.seed)
    rows = measured(recipe, options.rows, options.workers)
    return [row[name_of(measure)] for row in rows]


def command(
    what: str | None,
    arguments: Sequence[str] | None,
    run: Callable[[argparse.Namespace], Mapping[str, Any]],
    add_arguments: Callable[[argparse.ArgumentParser], None] | None = None,
) -> int:
    """A command line that measures frames and writes JSON; returns the exit code.

    Args:
        what: Documentation of the module.
        arguments: Of the command line.
        run: From the options to what is written.
        add_arguments: Adds options of its own.
    """
    parser = argparse.ArgumentParser(description=(what or "").partition("\n")[0])
    parser.add_argument("--frames", type=int, default=100, help="procedural frames")
    parser.add_argument("--suite", choices=sorted(_SUITES), default="mixed")
    parser.add_argument("--seed", type=int, default=0, help="of the suite")
    parser.add_argument("--workers", type=int, help="processes; default 2")
    parser.add_argument("--kitti", type=Path, help="real frames: folder of the object benchmark")
    parser.add_argument("--rows", type=Path, help="folder of the rows; default: in the cache")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    if add_arguments is not None:
        add_arguments(parser)
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    try:
        result = run(options)
    except AvsecError as error:
        _LOG.error("%s", error)
        return 1
    text = json.dumps(result, indent=1, allow_nan=False) + "\n"
    if options.json is None:
        sys.stdout.write(text)
    else:
        options.json.parent.mkdir(parents=True, exist_ok=True)
        options.json.write_text(text)
    return 0


def quantiles(values: Sequence[float | None]) -> dict[str, float | None]:
    """Mean and percentiles of what is known; None where nothing is."""
    known = [value for value in values if value is not None]
    names = ("p5", "p25", "p50", "p75", "p95")
    if not known:
        return dict.fromkeys(("mean", *names))
    found = np.percentile(known, [5, 25, 50, 75, 95])
    return {"mean": float(np.mean(known)), **dict(zip(names, map(float, found), strict=True))}


def _progress() -> Callable[[int, int], None]:
    from avsec_gym.commands.console import Progress

    return Progress("measuring")
