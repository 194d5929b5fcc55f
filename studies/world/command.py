"""The command line that all measurements of rendered frames share."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from avsec_gym.console import progress
from avsec_gym.world.capture import Capture
from avsec_gym.world.posed_scenes import PosedScene
from studies.answer import answer
from studies.world.frames import (
    SUITES,
    Measure,
    MeasuredFrames,
    MeasuredRows,
    Row,
    Scenes,
    SuiteScenes,
    measured,
)


def command(
    what: str | None,
    arguments: Sequence[str] | None,
    run: Callable[[argparse.Namespace], object],
    *,
    frames: int = 100,
    add_arguments: Callable[[argparse.ArgumentParser], None] | None = None,
) -> int:
    """Parse arguments, measure, write JSON.

    Args:
        what: Documentation of the module.
        arguments: Words of the command line; those of the process if None.
        run: The function from the options to the result, a dataclass.
        frames: How many by default.
        add_arguments: Function that adds options of its own.

    Returns:
        The exit code.
    """
    parser = argparse.ArgumentParser(description=(what or "").partition("\n")[0])
    parser.add_argument("--frames", type=int, default=frames, help="rendered frames")
    parser.add_argument("--suite", choices=sorted(SUITES), default="mixed")
    parser.add_argument("--seed", type=int, default=0, help="of the suite")
    parser.add_argument("--workers", type=int, help="processes; default: 2")
    parser.add_argument("--kitti", type=Path, help="real frames: folder of the object benchmark")
    parser.add_argument("--rows", type=Path, help="keeps the rows; default: in the cache")
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    if add_arguments is not None:
        add_arguments(parser)
    options = parser.parse_args(arguments)
    return answer(options, run)


def measure_all(
    options: argparse.Namespace,
    *measures: Measure,
    images: bool = True,
    scenes: Scenes | None = None,
    frames: int | None = None,
) -> MeasuredRows:
    """The rows of measures, of the frames that the options name; see `measured`.

    Args:
        options: The options of `command`.
        measures: What to measure.
        images: Whether it needs images and scans.
        scenes: The scenes in place of the suite's.
        frames: The number of frames in place of the options'.
    """
    scenes = scenes or SuiteScenes(options.suite, options.seed)
    recipe = MeasuredFrames(scenes, frames or options.frames, measures, images)
    with progress("measuring") as shown:
        return measured(recipe, workers=options.workers, rows=options.rows, on_progress=shown)


def measure_one(
    options: argparse.Namespace,
    measure: Callable[[PosedScene, Capture], Row],
    *,
    images: bool = True,
) -> list[Row]:
    """The rows of one measure."""
    return measure_all(options, measure, images=images).of(measure)
