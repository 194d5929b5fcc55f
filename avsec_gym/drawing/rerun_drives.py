"""Filmed drives as a recording for the Rerun viewer."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.closed_loop.drive_film import DriveFilm
from avsec_gym.drawing.film_strip import ShownDrive
from avsec_gym.drawing.rerun_stream import colour, recording
from avsec_gym.drawing.scenario_picture import BELIEVED, EGO, GOAL, REAL
from avsec_gym.geometry import Floats, rectangle_corners
from avsec_gym.planners.vehicle import BMW_320I

_LANE = "#b0b8be"


def write_drives_recording(drives: Sequence[ShownDrive], path: Path) -> None:
    """Write drives of one scene, each below its setting's name, on one timeline.

    Args:
        drives: The drives.
        path: The file, ``.rrd``; one that is there is replaced.

    Raises:
        ConfigurationError: Rerun's SDK is not installed.
    """
    with recording(path, "avsec drive") as stream:
        for shown in drives:
            _log(stream, shown.name, shown.film)


def _log(stream: Any, name: str, film: DriveFilm) -> None:
    import rerun as rr

    def draw(part: str, outlines: Sequence[Floats], shown: str, *, static: bool = False) -> None:
        # Rerun's y axis points down, as in an image; ours to the left.
        lines = [np.asarray(outline)[:, :2] * (1.0, -1.0) for outline in outlines]
        drawn = rr.LineStrips2D(lines, colors=[colour(shown)])
        stream.log(f"{name}/{part}", drawn, static=static)

    draw("lanes", film.lanes(), _LANE, static=True)
    draw("goal", [film.goal], GOAL, static=True)
    for instant, time in enumerate(film.times.tolist()):
        stream.set_time("time", duration=time)
        own = rectangle_corners(film.car[instant, [0, 1, 3]], BMW_320I.length, BMW_320I.width)
        there = film.present[instant]
        believed = film.believed[film.believed_at == instant]
        draw("car", [_closed(own)], EGO)
        draw("plan", [film.plans[film.plan_of == film.planned[instant]]], EGO)
        real = rectangle_corners(film.poses[instant, there], *film.sizes[there].T)
        draw("real", list(map(_closed, real)), REAL)
        boxes = rectangle_corners(believed[:, :3], believed[:, 3], believed[:, 4])
        draw("believed", list(map(_closed, boxes)), BELIEVED)
        stream.log(f"{name}/speed", rr.Scalars(float(film.car[instant, 2])))


def _closed(corners: Floats) -> Floats:
    return np.vstack([corners, corners[:1]])
