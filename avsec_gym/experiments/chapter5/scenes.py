"""The scenes of a run of chapter 5, and what is to be seen in each."""

from __future__ import annotations

from functools import cache

import numpy as np

from avsec_gym.attacks.side_area import (
    EVERYTHING,
    Roadside,
    RoadView,
    read_roadside,
    straight_roadside,
)
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.settings import WITHOUT_PYRAMID, Options
from avsec_gym.experiments.procedural_frames import (
    CONTESTED,
    PROCEDURAL,
    check_place,
    procedural_frames,
)
from avsec_gym.kitti.map_files import read_disparity, read_mask
from avsec_gym.runs.experiment import Configuration
from avsec_gym.scenario.frame_scenes import SUITES, FrameScenes, frame_scenes
from avsec_gym.scenario.scene import Scene
from avsec_gym.world.site import Surface

OPTIONS: Options = {
    "frames": "",
    "motion": "truth",
    "score_threshold": 0.3,
    "sanity_sheet": True,
    "patches": "",
    "dsgn": "",
    "stereo_rcnn": "",
}
"""``frames``: folders with the scenarios' images, with commas, where --scenarios names the authors'
labelled scenarios; ``motion``: see `Motion`, a classifier being the package's; ``sanity_sheet``:
whether losses are measured, and perturbed images looked at in whole grey levels as well, which
takes a third of the time;
``patches``: a folder of trained patches, and by the
detectors' names their weights, instead of the package's small ones: a file, or ``medium``."""
PYRAMID_OPTIONS = {**OPTIONS, WITHOUT_PYRAMID: ""}
"""And weights of the DSGN without its pyramid, which the package has none of."""


def scenes_of(configuration: Configuration) -> FrameScenes:
    """The scenes of a run, with their sensor data; procedural ones are made on first use."""
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


def roadside_of(scenes: FrameScenes, scene: Scene) -> Roadside:
    """Road and side area of a pair: by the world's own maps, or else by a straight road on a plane.

    Raises:
        DataError: A file is broken.
    """
    if _has_maps(scenes, scene):
        return read_roadside(scenes.data[scene.id].folder, scene.id)
    return straight_roadside(scenes.frame(scene), scene.boxes)


def road_view_of(scenes: FrameScenes, scene: Scene) -> RoadView:
    """The same of the left image alone, which takes a tenth of the time where there are maps."""
    if not _has_maps(scenes, scene):
        return roadside_of(scenes, scene).left
    folder, file = scenes.data[scene.id].folder, f"{scene.id}.png"
    surface = read_mask(folder / "surface_2" / file)
    disparity = np.nan_to_num(read_disparity(folder / "disparity_2" / file))
    return RoadView(surface == Surface.ROAD, np.isin(surface, EVERYTHING), disparity)


def _has_maps(scenes: FrameScenes, scene: Scene) -> bool:
    folder, file = scenes.data[scene.id].folder, f"{scene.id}.png"
    return all((folder / name / file).is_file() for name in ("surface_2", "disparity_2"))


@cache
def _scenes(scenarios: str, frames: str, limit: int | None, seed: int) -> FrameScenes:
    check_place(scenarios, (CONTESTED, *SUITES))
    if scenarios in (PROCEDURAL, CONTESTED):
        scenarios = str(procedural_frames(limit, seed, contested=scenarios == CONTESTED))
    if not frames:
        return frame_scenes(scenarios, count=limit, seed=seed)
    return frame_scenes(frames.split(","), scenarios=scenarios, count=limit, seed=seed)
