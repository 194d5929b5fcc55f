"""Filmed drives as a recording for the Rerun viewer."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.closed_loop.drive_film import DriveFilm
from avsec_gym.drawing.film_strip import Shown
from avsec_gym.drawing.scenario_picture import BELIEVED, EGO, GOAL, REAL
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, rectangle_corners
from avsec_gym.planners.vehicle import BMW_320I

_LANE = "#b0b8be"


def check_rerun() -> None:
    """Refuse to begin what could not be recorded.

    Raises:
        ConfigurationError: Rerun's SDK is not installed.
    """
    try:
        import rerun  # noqa: F401
    except ImportError:
        raise ConfigurationError(
            "recordings for Rerun need its SDK: pip install 'avsec-gym[rerun]'"
        ) from None


def write_recording(drives: Sequence[Shown], path: Path) -> None:
    """Write drives of one scene, each below its setting's name, on one timeline.

    Args:
        drives: The drives.
        path: The file, ``.rrd``; one that is there is replaced.

    Raises:
        ConfigurationError: Rerun's SDK is not installed.
    """
    check_rerun()
    import rerun as rr

    recording = rr.RecordingStream("avsec drive")
    recording.save(str(path))
    for shown in drives:
        _log(rr, recording, shown.name, shown.film)
    recording.flush()


def _log(rr: Any, recording: Any, name: str, film: DriveFilm) -> None:
    def draw(part: str, outlines: Sequence[Floats], colour: str, *, static: bool = False) -> None:
        # Rerun's y axis points down, as in an image; ours to the left.
        lines = [np.asarray(outline)[:, :2] * (1.0, -1.0) for outline in outlines]
        colours = [int(colour[at : at + 2], 16) for at in (1, 3, 5)]
        recording.log(f"{name}/{part}", rr.LineStrips2D(lines, colors=[colours]), static=static)

    draw("lanes", film.lanes(), _LANE, static=True)
    draw("goal", [film.goal], GOAL, static=True)
    for instant, time in enumerate(film.times.tolist()):
        recording.set_time("time", duration=time)
        own = rectangle_corners(film.car[instant, [0, 1, 3]], BMW_320I.length, BMW_320I.width)
        there = film.present[instant]
        believed = film.believed[film.believed_at == instant]
        draw("car", [_closed(own)], EGO)
        draw("plan", [film.plans[film.plan_of == film.planned[instant]]], EGO)
        real = rectangle_corners(film.poses[instant, there], *film.sizes[there].T)
        draw("real", list(map(_closed, real)), REAL)
        boxes = rectangle_corners(believed[:, :3], believed[:, 3], believed[:, 4])
        draw("believed", list(map(_closed, boxes)), BELIEVED)
        recording.log(f"{name}/speed", rr.Scalars(float(film.car[instant, 2])))


def _closed(corners: Floats) -> Floats:
    return np.vstack([corners, corners[:1]])
