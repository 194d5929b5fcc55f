"""What a driving-safety experiment leaves behind: records as CSV, pictures of what went wrong."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from pathlib import Path

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.scenario_picture import draw_episode, save_picture
from avsec_gym.evaluation.rates import DETECTIONS, AnyScene, Detected, DrivingSafety
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.pipeline import Episode, run_episode
from avsec_gym.planners.kept_tree import with_tree
from avsec_gym.planners.planner import Algorithm, MotionPrimitivePlanner, Planner
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.given_scene import AS_GIVEN
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion
from avsec_gym.storage.text_files import write_text


def write_records(result: DrivingSafety, path: Path) -> None:
    """One row for each planner, input, intention and scene."""
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(["planner", "input", "group", *SafetyRecord.__dataclass_fields__])
    for cell, records in result.records.items():
        for scene, record in zip(result.scenes.driven(cell.intention), records, strict=True):
            writer.writerow([cell.planner, cell.input, scene.group, *record.to_json().values()])
    write_text(path, text.getvalue(), overwrite=True)


def write_pictures(
    result: DrivingSafety,
    detected: Detected | None,
    folder: Path,
    most: int,
    on_progress: Progress = no_progress,
    planner_of: Callable[[str], Planner] | None = None,
) -> list[Path]:
    """Pictures of the scenes that detections made unsafe; without detections, of unsafe ones.

    Args:
        result: The experiment.
        detected: The detections that it was made with.
        folder: The folder of the files; made if need be.
        most: The largest number of pictures, spread over the rows.
        on_progress: Function that gets the number that is done, and of all.
        planner_of: The planner of a name, as of `driving_safety`.

    Returns:
        The files.
    """
    wanted: list[tuple[AnyScene, str, str]] = []
    for cell, records in result.records.items():
        if detected is not None and cell.input == DETECTIONS:
            flips = result.flips(cell.planner, cell.intention)
            wanted += [(scene, cell.planner, cell.intention) for scene, _, _ in flips]
        elif detected is None:
            pairs = zip(result.scenes.driven(cell.intention), records, strict=True)
            wanted += [(s, cell.planner, cell.intention) for s, r in pairs if not r.safe]
    spread = max(1, -(-len(wanted) // most)) if most else 1
    chosen = wanted[::spread][:most]
    boxes = {} if detected is None else detected.kept()
    motion = Motion(result.settings["motion"]["ground_truth" if detected is None else DETECTIONS])
    files = []
    for number, (scene, planner, intention) in enumerate(chosen, start=1):
        believed = None if detected is None else boxes.get(scene.id, Boxes3D.empty())
        way = Intention.STRAIGHT if intention == AS_GIVEN else Intention(intention)
        driver = (
            MotionPrimitivePlanner(Algorithm(planner))
            if planner_of is None
            else planner_of(planner)
        )
        shown = episode_with_tree(scene, way, believed, motion, driver)
        files.append(folder / f"{scene.id}_{intention}_{planner}.png".replace(" ", "-"))
        save_picture(draw_episode(shown), files[-1], overwrite=True)
        on_progress(number, len(chosen))
    return files


def episode_with_tree(
    scene: AnyScene,
    intention: Intention,
    believed: Boxes3D | None,
    motion: Motion,
    planner: Planner | None = None,
) -> Episode:
    """An episode whose plan keeps its search tree, for a picture, if the planner searches as A*."""
    planner = MotionPrimitivePlanner() if planner is None else planner
    return run_episode(scene, intention, believed, motion=motion, planner=with_tree(planner))
