"""The scenes of a run of chapter 5, and what is to be seen in each."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.experiment import Configuration
from avsec_gym.scenario.frame_scenes import FrameScenes, frame_scenes

OPTIONS: Mapping[str, Any] = {
    "frames": "",
    "motion": "truth",
    "score_threshold": 0.3,
    "patches": "",
    "dsgn": "",
    "stereo_rcnn": "",
}
"""``frames``: folders with the scenarios' images, with commas, where --scenarios names the authors'
labelled scenarios; ``motion``: see `Motion`; ``patches``: a folder of trained patches, and by the
detectors' names their weights, instead of those of the package."""


def scenes_of(configuration: Configuration) -> FrameScenes:
    """The scenes of a run, with their sensor data."""
    options = {**OPTIONS, **configuration.options}
    return _scenes(
        configuration.scenarios, options["frames"], configuration.limit, configuration.seed
    )


def labels_of(configuration: Configuration) -> dict[str, Boxes3D]:
    """What is to be seen in each scene of a run, with the regions not to care about.

    Raises:
        DataError: A file is missing or broken.
    """
    scenes = scenes_of(configuration)
    return {scene.id: scenes.labels(scene) for scene in scenes.scenes.labelled}


@cache
def _scenes(scenarios: str, frames: str, limit: int | None, seed: int) -> FrameScenes:
    if not frames:
        return frame_scenes(scenarios, count=limit, seed=seed)
    return frame_scenes(frames.split(","), scenarios=scenarios, count=limit, seed=seed)
