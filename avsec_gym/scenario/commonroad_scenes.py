"""Scenes from folders of CommonRoad files, as planning problems that are given whole."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.scenario.given_scene import GivenScene
from avsec_gym.scenario.scene_set import SceneSet, collected
from avsec_gym.storage.regular_files import is_folder


def commonroad_folder(folder: str | Path) -> SceneSet:
    """Scenes that CommonRoad files give; broken files are left out and reported.

    Raises:
        DataError: There is no such folder, or no file in it can be read.
    """
    from avsec_gym.scenario.builder import TIME_STEP
    from avsec_gym.scenario.commonroad import read_commonroad

    folder = Path(folder)
    if not is_folder(folder):
        raise DataError(
            "There is no such folder.",
            path=folder,
            remedy="Name a folder of CommonRoad 2020a XML files.",
        )
    scenes: list[GivenScene] = []
    errors: list[DataError] = []
    for path in sorted(folder.glob("*.xml")):
        try:
            scenario = read_commonroad(path)
            if abs(scenario.dt - TIME_STEP) > 1e-9:
                raise DataError(
                    f"its time steps have {scenario.dt} s, those of the planner {TIME_STEP} s.",
                    path=path,
                )
            scenes.append(GivenScene(scenario))
        except DataError as error:
            errors.append(error)
    if not scenes and not errors:
        raise DataError(
            "the folder holds no CommonRoad file.",
            path=folder,
            remedy="Name a folder of CommonRoad 2020a XML files.",
        )
    return collected(folder.name, scenes, [], errors)
