"""The frames of the benchmark for detectors of other projects, unattacked and under attack."""

from __future__ import annotations

from pathlib import Path

import torch

from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.benchmark.protocol import unknowing_attacks
from avsec_gym.benchmark.scene_sets import frozen_sets
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.sensor_files import write_image
from avsec_gym.pipeline import Pipeline
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.scene import Scene
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.folder_lock import locked_folder
from avsec_gym.storage.folders import make_folder
from avsec_gym.storage.regular_files import MAX_FILE_BYTES, is_there, read_bytes

_COPIED = {"calib": ".txt", "velodyne": ".bin"}
"""What no attack changes; labels are not handed out."""


def write_frames(
    root: Path,
    *,
    quick: bool = False,
    on_progress: Progress = no_progress,
) -> list[Path]:
    """Write the frames; those that are there are kept.

    The attacks are those on an unknown detector: by the gradients of the package's DSGN, and the
    patch. The pixels are the ones that an entry by name is driven by.

    Args:
        root: Folder; each set and setting has one of its own, ``root/SCENES/SETTING``.
        quick: Whether those of a quick entry.
        on_progress: Function that gets the number of frames that are there and that of all.

    Returns:
        The folders.

    Raises:
        DataError: They cannot be written.
    """
    # The detector takes no part: these attacks bring their own, or none.
    pipelines = {
        setting: Pipeline("oracle", attack) for setting, attack in unknowing_attacks("").items()
    }
    for frozen in frozen_sets().values():
        frozen.check()
    torch.set_num_threads(1)  # As in an entry: the last digits of gradients depend on it.
    with locked_folder(root):
        sets = [(frozen, frozen.frames(quick=quick)) for frozen in frozen_sets().values()]
        total = sum(len(scenes) for _, scenes in sets) * len(pipelines)
        folders, done = [], 0
        for frozen, scenes in sets:
            for setting, pipeline in pipelines.items():
                folder = root / frozen.name / setting
                for part in ("image_2", "image_3", *_COPIED):
                    make_folder(folder / "training" / part)
                folders.append(folder)
                for scene in scenes.scenes.labelled:
                    _write(folder / "training", scenes, scene, pipeline)
                    done += 1
                    on_progress(done, total)
    return folders


def _write(folder: Path, scenes: FrameScenes, scene: Scene, pipeline: Pipeline) -> None:
    """One frame; the right image is written last, and shows that all is there."""
    if is_there(folder / "image_3" / f"{scene.id}.png"):
        return
    source = scenes.data[scene.id].folder
    for part, suffix in _COPIED.items():
        file = f"{part}/{scene.id}{suffix}"
        write_bytes(folder / file, read_bytes(source / file, most=MAX_FILE_BYTES), overwrite=True)
    frame: SensorFrame = pipeline.tampered(
        scene, scenes.frame(scene), seed=(0, scene.number), disparity=scenes.disparity(scene)
    )
    for camera in (LEFT, RIGHT):
        path = folder / f"image_{camera}" / f"{scene.id}.png"
        write_image(path, frame.image(camera), overwrite=True)
