"""A picture of lanes, believed and real objects, search tree, trajectory and its outcome."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.drawing.figure_style import as_drawn
from avsec_gym.geometry import Floats
from avsec_gym.metrics.collision_check import footprints
from avsec_gym.metrics.safety import COLLISION, SAFE
from avsec_gym.pipeline import Episode
from avsec_gym.planners.vehicle import BMW_320I, Vehicle
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.storage.atomic_write import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, ROAD, LANE, GOAL = "#22303c", "#eef1f3", "#ffffff", "#f0c419"
REAL, BELIEVED, EGO, TREE = "#8795a1", "#d1495b", "#1b7fbd", "#7fb2d6"
_OUTCOMES = {SAFE: ("safe", "#2a8f5b"), COLLISION: ("collision", "#c1272d")}
_VIEW = (-9.0, 34.0, -11.5, 11.5)
"""x from, x to, y from, y to; metres around the start, in its frame."""
_MARGIN = 4.0
"""Metres around a trajectory that leads farther."""


def draw_episode(
    episode: Episode, *, vehicle: Vehicle = BMW_320I, title: str | None = None
) -> Figure:
    """The whole picture with its legend.

    Args:
        episode: The planned trajectory and its check; its plan shows a search tree if it kept one.
        vehicle: The vehicle that drives.
        title: Title beside the outcome; None: scenario and intention.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.2, 5.6), dpi=110, facecolor="white")
    axes = figure.add_axes((0.02, 0.11, 0.96, 0.77))
    draw_into(axes, episode, vehicle=vehicle)
    word, colour = _OUTCOMES.get(episode.record.outcome, ("no plan", "#b8860b"))
    problem = episode.problem
    if title is None:
        title = f"{problem.id} · {problem.intention or ''} · {problem.road_type or ''}".strip(" ·")
    figure.text(0.02, 0.945, as_drawn(title), size=13, weight="bold", color=INK, va="center")
    figure.text(
        0.98, 0.945, word.upper(), size=13, weight="bold", color=colour, va="center", ha="right"
    )
    figure.text(0.02, 0.9, _sentence(episode), size=9.5, color=INK, va="center")
    _legend(axes, figure, episode)
    return figure


def draw_into(axes: Axes, episode: Episode, *, vehicle: Vehicle = BMW_320I) -> None:
    """Draw the scene into given axes, x forward to the right, y left upwards."""
    from matplotlib.collections import LineCollection, PolyCollection

    problem, plan = episode.problem, episode.plan
    start = problem.start
    # The ground: lanes, goal regions, search tree.
    axes.set_facecolor("#dfe4e8" if problem.road.lanelets else ROAD)
    lanes = [np.array([*lane.left, *reversed(lane.right)]) for lane in problem.road.lanelets]
    axes.add_collection(PolyCollection(lanes, facecolor=ROAD, edgecolor=LANE, lw=1.6, zorder=1))
    for goal in problem.goals:
        for shape in goal.region or ():
            _fill(axes, shape.polygon(), GOAL, alpha=0.35, zorder=2, edge=GOAL)
    if plan.tree is not None and len(plan.tree) > 1:
        parents = plan.tree[1:, 2].astype(int)
        lines = np.stack([plan.tree[parents, :2], plan.tree[1:, :2]], axis=1)
        axes.add_collection(LineCollection(list(lines), colors=TREE, lw=0.7, alpha=0.7, zorder=3))
    # Obstacles: the real ones filled, the believed ones dashed where they differ.
    steps = (start.step, _last_step(episode))
    _obstacles(axes, episode.truth, fill=REAL, edge=INK, style="-", steps=steps)
    if not _same(episode.truth, problem.obstacles):
        _obstacles(axes, problem.obstacles, fill="none", edge=BELIEVED, style="--", steps=steps)
    # The trajectory, the vehicle at its start, the place of a collision.
    if plan.trajectory is not None:
        corners = footprints(plan.trajectory, vehicle)
        axes.add_collection(
            PolyCollection(list(corners[1:]), facecolor=EGO, edgecolor="none", alpha=0.05, zorder=5)
        )
        axes.plot(plan.trajectory[:, 0], plan.trajectory[:, 1], color=EGO, lw=2.2, zorder=7)
        last = corners[-1:]
        axes.add_collection(
            PolyCollection(list(last), facecolor="none", edgecolor=EGO, lw=1.4, zorder=7)
        )
    own = footprints(np.array([[start.x, start.y, 0.0, start.heading, 0.0]]), vehicle)
    axes.add_collection(PolyCollection(list(own), facecolor=EGO, edgecolor=INK, lw=1.0, zorder=8))
    if episode.record.collision and plan.trajectory is not None:
        step = round(episode.record.collision_time / problem.dt)
        axes.plot(
            *plan.trajectory[step, :2], marker="X", ms=15, mfc="#c1272d", mec="white", zorder=9
        )
    (x1, y1), (x2, y2) = _view(episode)
    axes.set_xlim(x1, x2)
    axes.set_ylim(y1, y2)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(False)
    _scale_bar(axes)


def save_picture(figure: Figure, path: str | Path, *, overwrite: bool = False) -> None:
    """Write a PNG, whole or not at all; its folder is made if need be.

    Raises:
        DataError: The file exists, or cannot be written.
    """
    content = io.BytesIO()
    figure.savefig(content, format="png")
    write_bytes(path, content.getvalue(), overwrite=overwrite)


def picture_array(figure: Figure) -> NDArray[np.uint8]:
    """The picture as an RGB array, shape (H, W, 3)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _sentence(episode: Episode) -> str:
    if not episode.record.collision:
        return episode.plan.explanation
    name = _words(episode.truth.categories[episode.record.collision_object or 0])
    return (
        f"{episode.plan.explanation}, but touches a real object ({name}) after"
        f" {episode.record.collision_time:.1f} s"
    )


def _view(episode: Episode) -> tuple[Floats, Floats]:
    """Lower left and upper right corner: what lies ahead of the start, and all of the episode."""
    start = episode.problem.start
    quarter = round(start.heading / (np.pi / 2)) * np.pi / 2
    turn = np.array([[np.cos(quarter), np.sin(quarter)], [-np.sin(quarter), np.cos(quarter)]])
    seen = np.array(_VIEW).reshape(2, 2).T @ turn + (start.x, start.y)
    if episode.plan.trajectory is not None:
        way = episode.plan.trajectory[:, :2]
        seen = np.vstack([seen, way.min(axis=0) - _MARGIN, way.max(axis=0) + _MARGIN])
    return seen.min(axis=0), seen.max(axis=0)


def _words(category: str) -> str:
    """``parked vehicle`` for CommonRoad's ``parkedVehicle``."""
    return re.sub("([A-Z])", r" \1", category).lower()


def _last_step(episode: Episode) -> int:
    trajectory = episode.plan.trajectory
    if trajectory is None:
        return episode.problem.last_step
    return episode.plan.first_step + len(trajectory) - 1


def _obstacles(
    axes: Axes, obstacles: Obstacles, *, fill: str, edge: str, style: str, steps: tuple[int, int]
) -> None:
    """Where they are at the first step, and where those that are drawn filled move to."""
    first, later = obstacles.polygons(steps[0]), obstacles.polygons(steps[1])
    for i in range(len(obstacles)):
        # What appears on the way is drawn where it ends.
        area = later[i] if first[i] is None else first[i]
        if area is None:
            continue
        _fill(axes, area, fill, alpha=0.95, zorder=4 if fill != "none" else 6, edge=edge, ls=style)
        if not obstacles.static[i] and later[i] is not None and fill != "none":
            _fill(axes, later[i], fill, alpha=0.25, zorder=4, edge=edge, ls=":")
            one, two = area.centroid, later[i].centroid
            arrow = {"arrowstyle": "-|>", "color": INK, "lw": 1.2, "shrinkA": 0, "shrinkB": 0}
            drawn = axes.annotate(
                "", (two.x, two.y), (one.x, one.y), arrowprops=arrow, zorder=6, annotation_clip=True
            )
            # Clipping by itself heeds the arrow's head only.
            assert drawn.arrow_patch is not None
            drawn.arrow_patch.set_clip_box(axes.bbox)


def _fill(
    axes: Axes,
    area: shapely.Geometry,
    colour: str,
    *,
    alpha: float,
    zorder: int,
    edge: str,
    ls: str = "-",
) -> None:
    for part in shapely.get_parts(area):
        points: Floats = np.array(part.exterior.coords)
        axes.fill(
            points[:, 0],
            points[:, 1],
            facecolor=colour,
            edgecolor=edge,
            alpha=alpha,
            lw=1.3 if colour == "none" else 0.9,
            ls=ls,
            zorder=zorder,
        )


def _same(one: Obstacles, two: Obstacles) -> bool:
    return (
        len(one) == len(two)
        and one.shapes == two.shapes
        and bool(np.allclose(one.poses[:, 0], two.poses[:, 0]))
    )


def _scale_bar(axes: Axes) -> None:
    (x1, _), (y1, _) = axes.get_xlim(), axes.get_ylim()
    axes.plot([x1 + 1, x1 + 6], [y1 + 1, y1 + 1], color=INK, lw=2, zorder=10)
    axes.text(x1 + 3.5, y1 + 1.35, "5 m", ha="center", size=8.5, color=INK, zorder=10)


def _legend(axes: Axes, figure: Figure, episode: Episode) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    entries: list[Any] = [
        Patch(facecolor=EGO, edgecolor=INK, label="ego vehicle"),
        Line2D([], [], color=EGO, lw=2.2, label="planned trajectory"),
        Patch(facecolor=GOAL, alpha=0.5, label="goal region"),
        Patch(facecolor=REAL, edgecolor=INK, label="real object"),
    ]
    if not _same(episode.truth, episode.problem.obstacles):
        entries.append(
            Patch(facecolor="none", edgecolor=BELIEVED, ls="--", label="believed object")
        )
    if episode.plan.tree is not None:
        entries.append(Line2D([], [], color=TREE, lw=1, label="search tree"))
    figure.legend(
        handles=entries,
        loc="lower center",
        ncol=len(entries),
        frameon=False,
        fontsize=9,
        labelcolor=INK,
        bbox_to_anchor=(0.5, 0.015),
        columnspacing=1.4,
    )


def draw_sheet(episodes: list[Episode], *, vehicle: Vehicle = BMW_320I) -> Figure:
    """Several episodes on one sheet, two in a row, each with its outcome."""
    from matplotlib.figure import Figure

    rows = -(-len(episodes) // 2)
    figure = Figure(figsize=(11.0, 3.35 * rows + 0.35), dpi=110, facecolor="white")
    for index, episode in enumerate(episodes):
        bottom = 1 - (index // 2 + 1) * 0.94 / rows
        axes = figure.add_axes((0.01 + 0.5 * (index % 2), bottom, 0.48, 0.84 / rows))
        draw_into(axes, episode, vehicle=vehicle)
        word, colour = _OUTCOMES.get(episode.record.outcome, ("no plan", "#b8860b"))
        problem = episode.problem
        attacked = "" if _same(episode.truth, problem.obstacles) else " · attacked detections"
        axes.set_title(
            problem.id + (f" · {problem.intention}" if problem.intention else "") + attacked,
            loc="left",
            size=10.5,
            color=INK,
            weight="bold",
        )
        axes.set_title(word.upper(), loc="right", size=10.5, color=colour, weight="bold")
    _legend(figure.axes[-1], figure, episodes[-1])
    return figure
