"""One scene of the demo in closed loop: the car drives on unattacked, under a laser, and defended.

The scene is found by rule, not picked: the first of the procedural drives in which a car that sees
nothing is to blame for a collision, one that sees all reaches its goal, and the light decides what
becomes of the car with the detector.  Looking for it takes minutes: of the demo's own seed it is
known (`TELLING`), of other seeds the last condition is left out.
"""

from __future__ import annotations

import base64
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from avsec_gym import __version__
from avsec_gym.attacks.facula import THESIS_RADII
from avsec_gym.drawing.embedded_image import embedded
from avsec_gym.drawing.film_strip import RATE, clip, gif
from avsec_gym.drawing.page_figure import CaptionedImage, Figure, PictureRow
from avsec_gym.drives.drive_folder import RECORD, DriveFolder, differences, has_drives
from avsec_gym.drives.drive_row import DriveRow
from avsec_gym.drives.driving import make_drives
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.scene_figures import KEY_OF_STRIPS, scene_figure, shown_drives
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.drives.telling import DrivenScene, by_scene, outcome_in_words
from avsec_gym.errors import DataError
from avsec_gym.progress import Progress, no_progress
from avsec_gym.runs.section import Section
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.storage.folder_lock import locked_folder
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.regular_files import is_file
from avsec_gym.validation.shipped import shipped_file

FOLDER = "drives"
"""The folder in a demo's in which its drives are kept."""
UNATTACKED, ATTACKED, DEFENDED = "unattacked", "attacked", "defended"
TELLING = {0: "drive-000235"}
"""The scene that `telling_drive` finds, by seed."""
_STRAIGHT = "straight"
_MOST_SCENES = 300
"""How many procedural drives are looked at; some four in a hundred are contested."""
_EYES = {"perception": "stereo", "detector": "stereo_rcnn"}
_LASER = {"name": "facula", "camera": 2, "radius": THESIS_RADII[1], "centre": [609, 173]}
"""The thesis' largest light, on the left camera, aimed at where a straight road vanishes."""
_VALIDATOR = {
    "name": "thresholds",
    "thresholds": str(shipped_file("thresholds", SensorSystem((LIDAR, 3, 2)))),
}
_ENDS = {"goal": "it reaches its goal", "stopped": "it stands", "time": "it still drives"}
_EVERY = 2
"""Instants from one picture of the film to the next."""
_SHARED = {**_EYES, "traffic": "reacting"}
SETTINGS = (
    DriveSetting(UNATTACKED, _SHARED),
    DriveSetting(ATTACKED, {**_SHARED, "attack": _LASER}),
    DriveSetting(DEFENDED, {**_SHARED, "attack": _LASER, "validator": _VALIDATOR}),
)


def drive_on(
    out: Path,
    seed: int,
    jobs: int = 1,
    on_progress: Progress = no_progress,
) -> None:
    """Make the drives, or those that are missing.

    Args:
        out: Folder of the drives.
        seed: The demo's seed.
        jobs: The number of processes, of which each makes whole drives.
        on_progress: Function that gets the number of drives that are done and that of all.

    Raises:
        DataError: The folder holds other drives, or damaged ones.
    """
    scenarios = _scenarios(seed)
    with locked_folder(out):
        folder = DriveFolder(out, _record(seed))
        if len(folder.rows) == len(SETTINGS):
            return
        known = {row["scenario"] for row in folder.rows.values()}
        scene = known.pop() if known else TELLING.get(seed) or contested_drive(scenarios)
        # The defended drive takes as long as the two others: it begins first.
        longest_first = reversed(SETTINGS)
        tasks = [DriveTask(setting.name, scene, _STRAIGHT, seed) for setting in longest_first]
        make_drives(
            tasks, SETTINGS, scenarios, folder, jobs=jobs, apart=True, on_progress=on_progress
        )


def are_demo_drives(out: Path, seed: int) -> bool:
    """Whether a folder holds the drives of the demo with this seed, or what they begin with.

    Args:
        out: Folder of the drives.
        seed: The demo's seed.
    """
    return is_file(out / RECORD) and not differences(out, _record(seed))


def _scenarios(seed: int) -> dict[str, Any]:
    return {"source": "drives", "seed": seed, "count": _MOST_SCENES}


def _record(seed: int) -> dict[str, Any]:
    return {
        "version": __version__,
        "scenarios": _scenarios(seed),
        "settings": {setting.name: setting.record for setting in SETTINGS},
    }


def contested_drive(scenarios: dict[str, Any]) -> str:
    """The first scene that a car drives safely if it sees all, and with a collision if nothing.

    Args:
        scenarios: The procedural drives, as the environment takes them.

    Raises:
        DataError: None of the scenes is such a one.
    """
    for scene in _contested_drives(scenarios):
        return scene
    raise DataError(
        f"of {_MOST_SCENES} procedural drives, none is contested.", remedy="Take another --seed."
    )


def telling_drive(scenarios: dict[str, Any], seed: int) -> str:
    """The first contested scene that is driven safely unattacked, and not under the laser.

    Args:
        scenarios: The procedural drives, as the environment takes them.
        seed: The demo's seed.

    Raises:
        DataError: None of the scenes is such a one.
    """
    unattacked, attacked = (
        (setting.name, setting.environment(scenarios)) for setting in SETTINGS[:2]
    )

    def ends(how: tuple[str, Any], scene: str) -> dict[str, Any]:
        name, environment = how
        return drive(environment, DriveTask(name, scene, _STRAIGHT, seed)).row

    for scene in _contested_drives(scenarios):
        if ends(unattacked, scene)["outcome"] == "goal" and ends(attacked, scene)["at_fault"]:
            return scene
    raise DataError(
        f"of {_MOST_SCENES} procedural drives, the light decides none.",
        remedy="Take another --seed.",
    )


def _contested_drives(scenarios: dict[str, Any]) -> Iterator[str]:
    blind, truth = (
        DriveSetting(name, {"perception": name}).environment(scenarios)
        for name in ("blind", "truth")
    )
    scenes: Any = blind.unwrapped
    for number, scene in enumerate(scenes.scenes.ids):
        task = DriveTask("", scene, _STRAIGHT, number)
        if drive(blind, task).row["at_fault"] and drive(truth, task).row["outcome"] == "goal":
            yield str(scene)


def driven_rows(out: Path) -> list[DriveRow]:
    """The rows of the drives, in the order of the settings; none where nothing was driven.

    Raises:
        DataError: The folder is damaged.
    """
    if not has_drives(out):
        return []
    rows = {row["setting"]: row for row in _folder(out).rows.values()}
    return [rows[setting.name] for setting in SETTINGS if setting.name in rows]


def driven_section(out: Path) -> Section | None:
    """The drives as a clip and as film strips; None where not all of them are there.

    Args:
        out: Folder of the drives.

    Raises:
        DataError: The folder is damaged.
    """
    rows = driven_rows(out)
    if len(rows) < len(SETTINGS):
        return None
    folder, scene = _folder(out), by_scene(rows)[0]
    return Section(
        "drives",
        "A car drives on under a laser",
        [in_words(rows)],
        [_film(folder, scene), scene_figure(folder, scene)],
        link="Driving on",
        context=KEY_OF_STRIPS,
    )


def in_words(rows: list[DriveRow]) -> str:
    """How the three drives ended, in a sentence each.

    Args:
        rows: The rows that `driven_rows` makes.
    """
    how = {
        row["setting"]: f"{_ENDS.get(row['outcome'], outcome_in_words(row))}"
        f" after {row['duration']:.1f} s"
        for row in rows
    }
    scene = rows[0]["scenario"]
    ends = {row["setting"]: row for row in rows}
    decides = ends[UNATTACKED]["outcome"] == "goal" and ends[ATTACKED]["at_fault"]
    also = ", and in which the light decides" if decides and scene in TELLING.values() else ""
    return (
        f"Scene {scene}, the first in which a car that sees nothing collides and one that sees all"
        f" does not{also}, driven by what Stereo R-CNN sees in rendered frames."
        f" Unattacked: {how[UNATTACKED]}. With a laser on the left camera: {how[ATTACKED]}."
        f" With the laser, and a validator that stops the car at an alarm: {how[DEFENDED]}."
    )


def _film(folder: DriveFolder, scene: DrivenScene) -> Figure:
    """The drives one below the other, moving."""
    pictures = clip(shown_drives(folder, scene))
    content = gif(pictures[::_EVERY], RATE // _EVERY)
    image = f"data:image/gif;base64,{base64.b64encode(content).decode()}"
    ends = "; ".join(f"{row['setting']}: {outcome_in_words(row)}" for row in scene.rows)
    words = f"A film of the same scene, driven three times. {ends}"
    film = CaptionedImage(image, ends, words, still=embedded(pictures[-1]))
    return Figure("The same scene, three times", pictures=[PictureRow([film], "repairs")])


def _folder(out: Path) -> DriveFolder:
    record = read_json_object(out / RECORD, remedy=f"Take {out} away: it is driven again.")
    return DriveFolder(out, {key: value for key, value in record.items() if key != "format"})
