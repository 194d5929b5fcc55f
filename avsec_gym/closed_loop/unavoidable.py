"""A certificate that no car could have avoided a collision, whatever it did from the start on.

For users of the library (docs/closed_loop.md); of ours, studies/driving_safety asks it.

The argument.  Within its limits of acceleration a and of turning its wheels, a car that starts at
speed v has after t seconds driven between the ways of full braking and of full acceleration.  It
cannot have turned further, nor its centre have moved further aside, than at full acceleration with
its wheels turning at their full rate to one side all the time.  The points that the car covers in
every one of these poses are its *core* at t: a rectangle along its first heading.  If something
touches the core at any t, the car has touched it by then at the latest.

The bounds are wide, so that the certificate is sound; where there is none, nothing follows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from avsec_gym.closed_loop.relative_poses import seen_from
from avsec_gym.closed_loop.tracks import Tracks
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.geometry import rectangle_polygons
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.scenario.planning_scenario import EgoState

ACCELERATION = 8.0
"""m/s2: the largest that the environment's actions have, both ways."""
_STEP = 0.01
_PARTS = 50
"""Parts of the time that integrals are summed over."""
_LONGEST = 2.0
"""Seconds that are looked at; after less than one, a core is empty at any usual speed."""


@dataclass(frozen=True)
class Certificate:
    """What cannot be avoided.

    Args:
        actor: Id of the actor.
        time: Seconds after the start by which the car has touched it.
    """

    actor: int
    time: float


def unavoidable(scene: TrafficScene) -> Certificate | None:
    """The first collision that no car can avoid from the start of a scene; None: none is proven.

    Args:
        scene: The scene; its actors play their tracks.
    """
    for time in np.arange(_STEP, _LONGEST, _STEP).tolist():
        area = core(scene.start, time)
        if area is None:
            return None
        hit = _touching(area, scene.start, scene.tracks, scene.sets_off + time)
        if hit is not None:
            return Certificate(hit, time)
    return None


def core(start: EgoState, time: float) -> shapely.Polygon | None:
    """What a car covers at a time whatever it does, as seen from its start; None: nothing.

    Args:
        start: The car's state; only speed and wheels matter.
        time: Seconds after the start.
    """
    speed, car = start.velocity, BMW_320I
    stopping = min(time, speed / ACCELERATION)
    least = speed * stopping - ACCELERATION * stopping**2 / 2
    most = speed * time + ACCELERATION * time**2 / 2
    # Wheels turn at their full rate, at full acceleration; sums of upper ends bound the integrals.
    ends = np.linspace(0.0, time, _PARTS + 1)[1:]
    part = time / _PARTS
    fastest = speed + ACCELERATION * ends
    wheels = abs(start.steering_angle) + car.max_steering_rate * ends
    if wheels[-1] > math.radians(45):
        return None
    headings = np.cumsum(fastest * np.tan(wheels) / car.wheelbase) * part
    slip = np.arctan(np.tan(wheels) * car.rear_axle / car.wheelbase)
    direction, turned = float(headings[-1] + slip[-1]), float(headings[-1])
    if direction > math.radians(45):
        return None
    aside = float((fastest * np.sin(headings + slip)).sum()) * part
    back, front = most, least * math.cos(direction)
    # A rectangle turned by up to `turned` holds the one that is shortened by what its corners lose.
    half_length = 0.5 * car.length * math.cos(turned) - 0.5 * car.width * math.sin(turned)
    half_width = 0.5 * car.width * math.cos(turned) - 0.5 * car.length * math.sin(turned)
    low, high = back - half_length, front + half_length
    width = half_width - aside
    if low >= high or width <= 0:
        return None
    return shapely.box(low, -width, high, width)


def _touching(area: shapely.Polygon, start: EgoState, tracks: Tracks, time: float) -> int | None:
    """The id of an actor that touches an area in the car's first frame."""
    there = [actor for actor in range(len(tracks)) if tracks.present(actor, time)]
    if not there:
        return None
    poses = np.array([tracks.state(actor, time)[:3] for actor in there])
    seen = seen_from((start.x, start.y, start.heading), poses)
    sizes = tracks.dimensions[there]
    hits = shapely.intersects(rectangle_polygons(seen, sizes[:, 2], sizes[:, 1]), area)
    return int(tracks.ids[there[int(np.argmax(hits))]]) if hits.any() else None
