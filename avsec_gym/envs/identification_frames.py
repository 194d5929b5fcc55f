"""The frames that a validator is shown: of recorded drives, or of labelled scenes.

Labelled scenes are in KITTI's object layout: a LiDAR and the cameras 3 and 2 see them, and a car
drives through them, since it is known what is there.  Recorded drives are in the raw layout, and
have more cameras; no car drives there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from avsec_gym.argument_checks import shown, whole_number
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import layout_folders
from avsec_gym.kitti.raw import KittiRaw
from avsec_gym.scenario.frame_scenes import (
    SUITES,
    FrameScenes,
    check_frame_scenes,
    frame_scenes_of,
)
from avsec_gym.scenario.roads import THESIS
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_sets import MIXED_CONTESTED
from avsec_gym.sensor_system import KITTI_SYSTEM, LIDAR, Sensor
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.suggestions import unknown_name
from avsec_gym.unknown_source import unknown_source
from avsec_gym.validation.recordings import raw_recordings

_ARGUMENTS = ("source", "first", "count")
"""Arguments of frames of drives."""


@dataclass(frozen=True, eq=False)
class PlayedFrame:
    """One frame without an attack, before it is read.

    Args:
        id: An id such as ``000107``, or ``2011_09_26_drive_0052_sync/0000000005`` of several
            drives.
        frame: Function that reads what the sensors deliver.
        scene: What is there, and is driven through; None: nothing is known of that.
    """

    id: str
    frame: Callable[[], SensorFrame]
    scene: Scene | None = None


def has_scenes(what: Any, road: str = THESIS) -> bool:
    """Whether `what` names labelled scenes; else it names frames of drives.  Nothing is read.

    Args:
        what: The name of the frames, see `played_frames`.
        road: The road that scenes are driven on, one of `avsec_gym.scenario.roads.ROADS`.

    Raises:
        ConfigurationError: It names neither, or what has no road of its own that is asked for.
        DataError: There is no such folder, or it has another layout.
    """
    source = what.get("source", "raw") if isinstance(what, Mapping) else what
    if isinstance(what, FrameScenes) or _is_object(source):
        check_frame_scenes(what, road)
        return True
    if road != THESIS:
        raise ConfigurationError(
            f'no car drives in recordings: give labelled scenes, such as scenarios="mixed", or'
            f' leave out road="{road}"'
        )
    _of_drives(what)
    return False


def usual_sensors(what: Any, road: str = THESIS) -> tuple[Sensor, ...]:
    """The sensors that the frames have: the LiDAR, and three cameras of drives or two of scenes.

    Arguments: see `has_scenes`.
    """
    return (LIDAR, 3, 2) if has_scenes(what, road) else KITTI_SYSTEM.sensors


def played_frames(
    what: Any, sensors: tuple[Sensor, ...], road: str = THESIS
) -> tuple[PlayedFrame, ...]:
    """The frames that have all of the sensors.

    Args:
        what: `frame_scenes` describes it for scenes; of drives it is a folder, ``raw``, or a
            dictionary with ``source``, ``first`` and ``count``.
        sensors: S_0 to S_n.
        road: The road that scenes are driven on, as of `has_scenes`.

    Raises:
        ConfigurationError: There are fewer frames than `first` leaves out.
        DataError: There is none, or it lacks a sensor.
    """
    if has_scenes(what, road):
        scenes = frame_scenes_of(what, road)
        every = [PlayedFrame(s.id, partial(scenes.frame, s), s) for s in scenes.scenes.labelled]
        played = tuple(each for each in every if _has(each.frame(), sensors))
        if not played:
            raise DataError(
                f"None of the {len(every)} scenes has the sensors {' '.join(map(str, sensors))}.",
                path=scenes.data[every[0].id].folder,
                remedy="Scans stand in velodyne/, images in image_2/ and image_3/.",
            )
        return played
    source, first, count = _of_drives(what)
    if source == "raw":
        from avsec_gym.world.export import default_suite

        source = default_suite("raw")
    recorded = raw_recordings(source, sensors).frames
    chosen = recorded[first:][:count]
    if not chosen:
        raise ConfigurationError(f"of {len(recorded)} frames, none is left from {first} on")
    return tuple(PlayedFrame(each.id, each.frame) for each in chosen)


def _is_object(source: Any) -> bool:
    """Whether a source is in KITTI's object layout, or a list of such."""
    if isinstance(source, list | tuple):
        return bool(source) and all(_is_object(each) for each in source)
    if not isinstance(source, str | Path):
        return False
    if str(source) in (*SUITES, MIXED_CONTESTED):
        return True
    root = Path(source)
    return is_folder(root) and any(map(layout_folders, (root / "training", root)))


def _has(frame: SensorFrame, sensors: tuple[Sensor, ...]) -> bool:
    return all(
        frame.has_points if sensor == LIDAR else sensor in frame.images for sensor in sensors
    )


def _of_drives(what: Any) -> tuple[str | Path, int, int | None]:
    """Where the frames are, from which one on, and how many; none is read.

    Raises:
        ConfigurationError: The arguments name no recording.
        DataError: There is no such folder, or it has another layout.
    """
    given = what if isinstance(what, Mapping) else {"source": what}
    for name in given:
        if name not in _ARGUMENTS:
            problem = f"frames are named by source, first and count, not by {shown(name)}"
            raise ConfigurationError(unknown_name(problem, str(name), _ARGUMENTS))
    first = whole_number("first", given.get("first", 0), 0)
    count = None if given.get("count") is None else whole_number("count", given["count"], 1)
    source = given.get("source", "raw")
    if not isinstance(source, str | Path):
        raise ConfigurationError(
            "scenarios are a folder in KITTI's raw or object layout, 'raw', or a default suite, "
            f"got {shown(source)}"
        )
    if source != "raw":
        if not is_folder(source):
            expected = (
                "Name a folder in KITTI's raw or object layout, 'raw', or a default suite "
                f"({', '.join(SUITES)})."
            )
            raise unknown_source(str(source), ["raw", *SUITES], expected)
        KittiRaw(source)  # Refuses a folder of another layout.
    return source, first, count
