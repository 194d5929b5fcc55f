"""One scene of the demo in closed loop: the car drives on unattacked, under a laser, and defended.

Where a demo has scenes enough to be a report, it is also driven defended without a laser: a
validator that always stops the car would look as good under the laser as one that is right.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from avsec_gym import __version__
from avsec_gym.attacks.facula import THESIS_RADII
from avsec_gym.drives.drive_folder import RECORD, DriveFolder, differences
from avsec_gym.drives.driving import make_drives
from avsec_gym.drives.one_drive import Driven, DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.experiments.demo.telling_drive import (
    MOST_SCENES,
    STRAIGHT,
    TELLING,
    contested_drive,
)
from avsec_gym.progress import Progress, no_progress
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.storage.folder_lock import locked_folder
from avsec_gym.storage.regular_files import is_file
from avsec_gym.validation.shipped import shipped_file

FOLDER = "drives"
"""The folder in a demo's in which its drives are kept."""
UNATTACKED, ATTACKED, DEFENDED = "unattacked", "attacked", "defended"
CONTROL = "defended-unattacked"
"""Names of the settings."""
_EYES = {"perception": "stereo", "detector": "stereo_rcnn"}
_LASER = {"name": "facula", "camera": 2, "radius": THESIS_RADII[1], "centre": [609, 173]}
"""The thesis' largest light, on the left camera, aimed at where a straight road vanishes."""
_VALIDATOR = {
    "name": "thresholds",
    "thresholds": str(shipped_file("thresholds", SensorSystem((LIDAR, 3, 2)))),
}
_SHARED = {**_EYES, "traffic": "reacting"}
HANDOVER = 1.0
"""Seconds that a defended car stands by alarms before a human takes over."""
_DEFENCE = {**_SHARED, "validator": _VALIDATOR, "handover": HANDOVER}
SETTINGS = (
    DriveSetting(UNATTACKED, _SHARED),
    DriveSetting(ATTACKED, {**_SHARED, "attack": _LASER}),
    DriveSetting(DEFENDED, {**_DEFENCE, "attack": _LASER}),
)
"""The settings of every demo."""
CONTROL_SETTING = DriveSetting(CONTROL, _DEFENCE)
"""The setting that shows needless stops."""
_ORDER = (CONTROL, UNATTACKED, ATTACKED, DEFENDED)
"""The order of the drives: those that take longest begin first."""


def drive_on(
    out: Path,
    seed: int,
    jobs: int = 1,
    on_progress: Progress = no_progress,
    *,
    control: bool = False,
    but_last: bool = False,
    last: Driven | None = None,
) -> None:
    """Make the drives, or those that are missing.

    Args:
        out: Folder of the drives.
        seed: The demo's seed.
        jobs: The number of processes, of which each makes whole drives.
        on_progress: Function that gets the number of drives that are done and that of all.
        control: Whether the validator also drives without a laser.
        but_last: Leave the last of them out: another process makes it.
        last: What `last_drive` has made; None: it is made here.

    Raises:
        DataError: The folder holds other drives, or damaged ones.
    """
    scenarios, settings = _scenarios(seed), _settings(control=control)
    with locked_folder(out):
        folder = DriveFolder(out, _record(seed, control=control))
        if len(folder.rows) == len(settings):
            return
        known = {row["scenario"] for row in folder.rows.values()}
        scene = known.pop() if known else _scene(seed, scenarios)
        names = sorted((setting.name for setting in settings), key=_ORDER.index)
        tasks = [DriveTask(name, scene, STRAIGHT, seed) for name in names]
        apart = but_last or last is not None
        make_drives(
            tasks[:-1] if apart else tasks, settings, scenarios, folder,
            jobs=jobs, apart=True, views=True, on_progress=on_progress,
        )  # fmt: skip
        if last is not None and last.row["id"] not in folder.rows:
            folder.add(last)
            on_progress(len(tasks), len(tasks))


def has_known_scene(seed: int) -> bool:
    """Whether it is known in which scene a demo drives on, without a search.

    Args:
        seed: The demo's seed.
    """
    return seed in TELLING


def last_drive(seed: int) -> Driven:
    """The last of the drives in a known scene, filed nowhere.

    Args:
        seed: The demo's seed, of a known scene.
    """
    setting = next(each for each in SETTINGS if each.name == _ORDER[-1])
    task = DriveTask(setting.name, TELLING[seed].scene, STRAIGHT, seed)
    return drive(setting.environment(_scenarios(seed)), task, setting.driver, views=True)


def are_demo_drives(out: Path, seed: int, *, control: bool = False) -> bool:
    """Whether a folder holds the drives of the demo with this seed, or what they begin with.

    Args:
        out: Folder of the drives.
        seed: The demo's seed.
        control: Whether the validator also drives without a laser.
    """
    return is_file(out / RECORD) and not differences(out, _record(seed, control=control))


def _settings(*, control: bool) -> tuple[DriveSetting, ...]:
    return (*SETTINGS, CONTROL_SETTING) if control else SETTINGS


def _scenarios(seed: int) -> dict[str, Any]:
    return {"source": "drives", "seed": seed, "count": MOST_SCENES}


def _record(seed: int, *, control: bool) -> dict[str, Any]:
    settings = _settings(control=control)
    return {
        "version": __version__,
        "scenarios": _scenarios(seed),
        "settings": {setting.name: setting.record for setting in settings},
    }


def _scene(seed: int, scenarios: dict[str, Any]) -> str:
    return TELLING[seed].scene if seed in TELLING else contested_drive(scenarios)
