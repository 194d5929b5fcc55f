"""Makes drives, in this process or in several, and files them in one order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from functools import partial
from itertools import groupby
from typing import Any

from avsec_gym.drives.drive_folder import DriveFolder
from avsec_gym.drives.one_drive import Driven, DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.progress import Progress, no_progress
from avsec_gym.worker_processes import each_in_processes

Tasks = tuple[DriveTask, ...]


def make_drives(
    tasks: Sequence[DriveTask],
    settings: Sequence[DriveSetting],
    scenarios: Any,
    folder: DriveFolder,
    *,
    jobs: int = 1,
    apart: bool = False,
    views: bool = False,
    on_progress: Progress = no_progress,
) -> None:
    """Make the drives that a folder lacks.

    Rows are filed in the order of the tasks, whichever process made them.

    Args:
        tasks: All drives; those of one scene follow each other, as processes share them by scene.
        settings: The settings that the tasks name.
        scenarios: The scenes, as the environment takes them.
        folder: Where the results go.
        jobs: The number of processes; 1 is this very one.
        apart: Processes share the work drive by drive; else scene by scene, which each has to make.
        views: Whether what the left cameras show is kept, too.
        on_progress: Function that gets the number of drives that are done and that of all.

    Raises:
        ConfigurationError: A part does not fit a scene.
        DataError: A file is missing or broken, or a process died.
    """
    done = len([task for task in tasks if task.id in folder.rows])
    on_progress(done, len(tasks))
    for driven in _driven(tasks, settings, scenarios, folder, jobs, apart, views):
        folder.add(driven)
        done += 1
        on_progress(done, len(tasks))


def _driven(
    tasks: Sequence[DriveTask],
    settings: Sequence[DriveSetting],
    scenarios: Any,
    folder: DriveFolder,
    jobs: int,
    apart: bool,
    views: bool,
) -> Iterator[Driven]:
    left = [task for task in tasks if task.id not in folder.rows]
    prepare = partial(_Drives, tuple(settings), scenarios, views)
    if jobs == 1:
        drives = prepare()
        for task in left:
            yield from drives((task,))
        return
    scenes: list[Tasks] = [
        tuple(group)
        for _, group in groupby(
            left, lambda task: task.id if apart else (task.scenario, task.intention)
        )
    ]
    results = each_in_processes(prepare, scenes, jobs, threads=1, folder=folder.out)
    # Scenes that are done before their turn wait for it.
    waiting: dict[Tasks, list[Driven]] = {}
    turn = iter(scenes)
    following = next(turn, None)
    with closing(results):
        for scene, drives_of_scene in results:
            waiting[scene] = drives_of_scene
            while following in waiting:
                yield from waiting.pop(following)
                following = next(turn, None)


class _Drives:
    """Drives scenes; made once in each process.

    Args:
        settings: All settings; an environment is made when its setting is first driven.
        scenarios: The scenes, as the environment takes them.
        views: Whether what the left cameras show is kept, too.
    """

    def __init__(self, settings: Sequence[DriveSetting], scenarios: Any, views: bool) -> None:
        self._settings = {setting.name: setting for setting in settings}
        self._scenarios, self._views = scenarios, views
        self._environments: dict[str, Any] = {}

    def __call__(self, tasks: Tasks) -> list[Driven]:
        return [
            drive(
                self._environment(task.setting),
                task,
                self._settings[task.setting].driver,
                views=self._views,
            )
            for task in tasks
        ]

    def _environment(self, setting: str) -> Any:
        if setting not in self._environments:
            self._environments[setting] = self._settings[setting].environment(self._scenarios)
        return self._environments[setting]
