"""A planned scene as a recording: lanes, goal, what is there and what is believed, over time."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from avsec_gym.drawing.rerun_stream import colour, recording
from avsec_gym.drawing.scenario_picture import BELIEVED, EGO, GOAL, REAL, TREE
from avsec_gym.geometry import Floats
from avsec_gym.metrics.collision_check import footprints
from avsec_gym.pipeline import Episode
from avsec_gym.planners.vehicle import BMW_320I, Vehicle
from avsec_gym.scenario.obstacles import Obstacles

_LANE = "#b0b8be"


def write_scene_recording(episode: Episode, path: Path, *, vehicle: Vehicle = BMW_320I) -> None:
    """Write a planned episode on the ground plane: x forward, y left, metres from its start.

    Heights are unknown to the planner, and none are drawn.

    Args:
        episode: The planned trajectory and its check; its plan shows a search tree if it kept one.
        path: The file, ``.rrd``; one that is there is replaced.
        vehicle: The vehicle that drives.

    Raises:
        ConfigurationError: Rerun's SDK is not installed.
    """
    problem, plan = episode.problem, episode.plan
    with recording(path, f"scene {problem.id}") as stream:
        import rerun as rr

        stream.log("/", rr.ViewCoordinates.FLU, static=True)
        # What stays: road, goal, the whole trajectory, the search.
        _outlines(stream, "lanes", (lane.polygon() for lane in problem.road.lanelets), _LANE)
        shapes = (shape.polygon() for goal in problem.goals for shape in goal.region or ())
        _outlines(stream, "goal", shapes, GOAL)
        if plan.tree is not None and len(plan.tree) > 1:
            parents = plan.tree[1:, 2].astype(int)
            edges = np.stack([plan.tree[parents, :2], plan.tree[1:, :2]], axis=1)
            _lines(stream, "search", list(edges), TREE, static=True)
        steps, corners = [problem.start.step], np.zeros((0, 4, 2))
        if plan.trajectory is not None:
            _lines(stream, "trajectory", [plan.trajectory[:, :2]], EGO, static=True)
            steps = [plan.first_step + i for i in range(len(plan.trajectory))]
            corners = footprints(plan.trajectory, vehicle)
        text = f"{episode.record.outcome}: {plan.explanation}"
        stream.log("outcome", rr.TextDocument(text), static=True)
        # What moves.
        for i, step in enumerate(steps):
            stream.set_time("time", duration=(step - problem.start.step) * problem.dt)
            _obstacles(stream, "real", episode.truth, step, REAL)
            _obstacles(stream, "believed", problem.obstacles, step, BELIEVED)
            if i < len(corners):
                _lines(stream, "car", [np.vstack([corners[i], corners[i][:1]])], EGO)


def _obstacles(stream: Any, entity: str, obstacles: Obstacles, step: int, shown: str) -> None:
    areas = [area for area in obstacles.polygons(step) if area is not None]
    _outlines(stream, entity, areas, shown, static=False)


def _outlines(
    stream: Any, entity: str, areas: Iterable[Any], shown: str, *, static: bool = True
) -> None:
    parts = [part for area in areas for part in shapely.get_parts(area)]
    rings = [np.array(part.exterior.coords)[:, :2] for part in parts]
    _lines(stream, entity, rings, shown, static=static)


def _lines(
    stream: Any, entity: str, lines: list[Floats], shown: str, *, static: bool = False
) -> None:
    import rerun as rr

    flat = [np.c_[line, np.zeros(len(line))] for line in lines]
    drawn = rr.LineStrips3D(flat, colors=[colour(shown)], radii=0.05)
    stream.log(entity, drawn, static=static)
