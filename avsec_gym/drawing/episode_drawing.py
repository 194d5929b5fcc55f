"""An episode from above as SVG: lanes, goal, the real, the believed, and the planned trajectory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import shapely

from avsec_gym.geometry import Floats
from avsec_gym.metrics.collision_check import footprints
from avsec_gym.pipeline import Episode
from avsec_gym.planners.vehicle import BMW_320I, Vehicle
from avsec_gym.scenario.obstacles import Obstacles

_AHEAD, _ASIDE = (-7.0, 38.0), 11.0
"""Metres that are shown, from behind to ahead of the start, and to either side."""
_PIXELS = 12.0
"""Pixels to the metre."""
_HOLD = 1.5
"""Seconds that the end of an episode is shown before it begins again."""


def draw_episode_from_above(episode: Episode, *, vehicle: Vehicle = BMW_320I) -> str:
    """The first 38 m, forward to the right; class names identify each shape.

    The car and what really moves do so, at the pace of the plan, up to a collision, again and
    again: the page has `pauseAnimations` to stop them.

    Args:
        episode: The planned trajectory and its check.
        vehicle: The vehicle that drives.
    """
    width, height = (_AHEAD[1] - _AHEAD[0]) * _PIXELS, 2 * _ASIDE * _PIXELS
    parts = "".join(_parts(episode, vehicle))
    label = f"The episode from above: {episode.record.outcome}"
    return (
        f'<svg viewBox="0 0 {width:g} {height:g}" class="drive" role="img" aria-label="{label}">'
        f'<rect width="{width:g}" height="{height:g}" class="ground"/>{parts}</svg>'
    )


def _parts(episode: Episode, vehicle: Vehicle) -> Iterator[str]:
    problem, plan = episode.problem, episode.plan
    bounds = {side for lane in problem.road.lanelets for side in (lane.left, lane.right)}
    for bound in sorted(bounds):
        points = np.array(bound)
        if np.abs(points[:, 1]).max() < _ASIDE:
            yield f'<polyline points="{_places(points)}" class="lane"/>'
    for goal in problem.goals:
        for shape in goal.region or ():
            yield from _area(shape.polygon(), "goal")
    last = problem.last_step
    if plan.trajectory is not None:
        last = plan.first_step + len(plan.trajectory) - 1
    if plan.trajectory is not None and episode.record.collision:
        last = plan.first_step + round(episode.record.collision_time / problem.dt)
    yield from _obstacles(episode.truth, range(problem.start.step, last + 1), problem.dt)
    for area in problem.obstacles.polygons(problem.start.step):
        if area is not None:
            yield from _area(area, "believed")
    if plan.trajectory is not None:
        for outline in footprints(plan.trajectory, vehicle)[::3]:
            yield f'<polygon points="{_places(outline)}" class="swept"/>'
        yield f'<polyline points="{_places(plan.trajectory[:, :2])}" class="trajectory"/>'
    start = problem.start
    own = footprints(np.array([[start.x, start.y, 0.0, start.heading, 0.0]]), vehicle)[0]
    way = [own]
    if plan.trajectory is not None:
        way = [*footprints(plan.trajectory[: last + 1 - plan.first_step], vehicle)]
    yield _moving(way, problem.dt, "ego")
    if episode.record.collision and plan.trajectory is not None:
        x, y = _at(plan.trajectory[round(episode.record.collision_time / problem.dt), :2][None])[0]
        yield (
            f'<path d="M{x - 9:.1f} {y - 9:.1f}l18 18m0 -18l-18 18" class="contact-edge"/>'
            f'<path d="M{x - 9:.1f} {y - 9:.1f}l18 18m0 -18l-18 18" class="contact"/>'
        )
    left, bottom = 10.0, 2 * _ASIDE * _PIXELS - 12
    yield f'<path d="M{left:g} {bottom:g}h{5 * _PIXELS:g}" class="scale"/>'


def _obstacles(obstacles: Obstacles, steps: range, dt: float) -> Iterator[str]:
    """Where they are, and faintly where those that move are going to be."""
    now, later = obstacles.polygons(steps[0]), obstacles.polygons(steps[-1])
    moving = ~obstacles.static
    for number in np.flatnonzero(moving).tolist():
        if later[number] is not None:
            yield from _area(later[number], "real later")
    ways = [obstacles.polygons(step) for step in steps] if moving.any() else []
    for number, area in enumerate(now):
        if area is None:
            continue
        way = [areas[number] for areas in ways] if moving[number] else []
        # What comes, goes or is of several parts stays where it begins.
        if way and all(isinstance(each, shapely.Polygon) for each in way):
            yield _moving([np.array(each.exterior.coords) for each in way], dt, "real")
        else:
            yield from _area(area, "real")


def _moving(outlines: Sequence[Floats], dt: float, kind: str) -> str:
    """A shape that goes through outlines of as many corners, one for each time step."""
    first, seconds = _places(outlines[0]), dt * (len(outlines) - 1)
    if seconds == 0:
        return f'<polygon points="{first}" class="{kind}"/>'
    total = seconds + _HOLD
    values = ";".join(_places(each) for each in (*outlines, outlines[-1]))
    times = ";".join(f"{dt * step / total:.4f}" for step in range(len(outlines))) + ";1"
    return (
        f'<polygon points="{first}" class="{kind}"><animate attributeName="points"'
        f' values="{values}" keyTimes="{times}" dur="{total:g}s" repeatCount="indefinite"/>'
        "</polygon>"
    )


def _area(area: shapely.Geometry, kind: str) -> Iterator[str]:
    for part in shapely.get_parts(area):
        yield f'<polygon points="{_places(np.array(part.exterior.coords))}" class="{kind}"/>'


def _places(points: Floats) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in _at(points))


def _at(points: Floats) -> Floats:
    """Pixels of points of the ego frame, shape (N, 2)."""
    return (points[:, :2] * (1, -1) + (-_AHEAD[0], _ASIDE)) * _PIXELS
