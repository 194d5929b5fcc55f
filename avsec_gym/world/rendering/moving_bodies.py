"""Rays that leave at different times, in a scene of which some objects move meanwhile.

The triangles of a scene stay where they are at time 0.  A ray that leaves at time t is turned and
shifted instead, as a moving object sees it: it meets the object at rest where the ray itself meets
the object that has moved.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.world.mesh import Float32s, Int32s
from avsec_gym.world.rendering.planar_motion import PlanarMotion
from avsec_gym.world.rendering.ray_scene import RayScene
from avsec_gym.world.rendering.renderer import Renderer

_BEYOND = np.float32(2e-3)
"""Metres behind a surface at which a ray goes on."""
_MOST_SURFACES = 24
"""Most surfaces that a ray passes on its way through or to one object; beyond, it meets nothing."""


class MovingBody(NamedTuple):
    """An object of a scene that moves."""

    object_id: int
    pose: tuple[float, float, float]
    """Position x, y (metres) and heading (radians) in the world at time 0."""
    motion: PlanarMotion


class Rays(NamedTuple):
    """Rays and the times at which they leave."""

    origins: Float32s
    """Metres, shape (n, 3)."""
    directions: Float32s
    """Unit vectors, shape (n, 3)."""
    seconds: Float32s
    """Shape (n,)."""

    def of(self, which: NDArray[np.intp]) -> Rays:
        """Some of them."""
        return Rays(*(np.ascontiguousarray(column[which]) for column in self))


class SweptScene:
    """Traces rays that leave at different times.

    Args:
        renderer: Renderer of the scene at time 0.
        bodies: The objects that move; all else stands.
        pulse_angle: Width of a ray, radians; see `Renderer.hits`.
    """

    def __init__(
        self, renderer: Renderer, bodies: Sequence[MovingBody], pulse_angle: float
    ) -> None:
        self._renderer, self._angle = renderer, pulse_angle
        there = [(body, _sphere(renderer.scene, body.object_id)) for body in bodies]
        self._bodies = [(body, sphere) for body, sphere in there if sphere is not None]
        self._moves = np.zeros(int(renderer.scene.object_id.max(initial=0)) + 2, bool)
        self._moves[[body.object_id for body, _ in self._bodies]] = True

    def hits(self, rays: Rays, layers: int = 1) -> tuple[Int32s, Float32s]:
        """First faces (-1 for none) and their distances (metres, infinite for none), (n,) each.

        Args:
            rays: The rays.
            layers: Largest number of layers of leaves that a ray passes between.
        """
        found = self._renderer.hits(rays.origins, rays.directions, self._angle, layers)
        face, distance = found.face, found.distance
        # Moving objects are no longer, or not yet, where they stand at time 0: rays go on.
        ghost = np.flatnonzero(self._on_moving(face))
        if len(ghost):
            face[ghost], distance[ghost] = self._past_bodies(
                rays.of(ghost), distance[ghost], layers
            )
        # Each moving object is met where it is when the ray leaves.
        for body, sphere in self._bodies:
            near = _near(rays, distance, body, sphere)
            hit_face, hit_distance = self._on_body(body, sphere, rays.of(near))
            nearer = hit_distance < distance[near]
            face[near[nearer]] = hit_face[nearer]
            distance[near[nearer]] = hit_distance[nearer]
        return face, distance

    def at_rest(self, face: Int32s, rays: Rays) -> tuple[Float32s, Float32s]:
        """Origins and directions of rays as the objects that they hit see them at time 0.

        Args:
            face: Faces that were hit, shape (n,).
            rays: The rays.
        """
        if not self._bodies:
            return rays.origins, rays.directions
        origins, directions = rays.origins.copy(), rays.directions.copy()
        objects = np.where(face >= 0, self._renderer.scene.object_id[np.maximum(face, 0)], -1)
        for body, _ in self._bodies:
            own = np.flatnonzero(objects == body.object_id)
            origins[own], directions[own], _ = _as_seen(body, rays.of(own))
        return origins, directions

    def _past_bodies(self, rays: Rays, distance: Float32s, layers: int) -> tuple[Int32s, Float32s]:
        """What rays meet that go on through the moving bodies, which stand in their way."""
        free = distance + _BEYOND
        on = np.arange(len(free))
        for _ in range(_MOST_SURFACES):
            behind = self._onward(rays.of(on), free[on])
            again = self._on_moving(behind[0])
            on = on[again]
            if len(on) == 0:
                break
            free[on] = behind[1][again] + _BEYOND
        # From behind the last of their surfaces on, nothing but what stands is met.
        starts = rays.origins + free[:, None] * rays.directions
        last = self._renderer.hits(starts, rays.directions, self._angle, layers)
        found = np.where(self._on_moving(last.face), -1, last.face)
        return found, np.where(found >= 0, last.distance + free, np.inf).astype(np.float32)

    def _on_body(self, body: MovingBody, sphere: Floats, rays: Rays) -> tuple[Int32s, Float32s]:
        """Faces (-1 for none) and distances at which rays meet a moving body."""
        rays = Rays(*_as_seen(body, rays))
        face = np.full(len(rays.seconds), -1, np.int32)
        distance = np.full(len(face), np.inf, np.float32)
        # Between entering and leaving the body's sphere, all surfaces but its own are passed.
        along = ((sphere[:3].astype(np.float32) - rays.origins) * rays.directions).sum(axis=1)
        free, leaves = np.maximum(along - sphere[3], 0.0).astype(np.float32), along + sphere[3]
        on = np.arange(len(face))
        for _ in range(_MOST_SURFACES):
            if len(on) == 0:
                break
            met, where = self._onward(rays.of(on), free[on])
            own = (met >= 0) & (self._renderer.scene.object_id[met] == body.object_id)
            face[on[own]], distance[on[own]] = met[own], where[own]
            again = ~own & (where < leaves[on])
            on = on[again]
            free[on] = where[again] + _BEYOND
        return face, distance

    def _onward(self, rays: Rays, free: Float32s) -> tuple[Int32s, Float32s]:
        """Faces and distances that rays meet beyond some distance."""
        starts = rays.origins + free[:, None] * rays.directions
        found = self._renderer.scene.hits(starts, rays.directions)
        return found.face, found.distance + free

    def _on_moving(self, face: Int32s) -> NDArray[np.bool_]:
        objects = self._renderer.scene.object_id[np.maximum(face, 0)]
        return (face >= 0) & self._moves[objects]


def _sphere(scene: RayScene, object_id: int) -> Floats | None:
    """Centre and radius of an object at time 0, metres, shape (4,); None if it is not there."""
    faces = scene.faces[scene.object_id == object_id]
    if len(faces) == 0:
        return None
    corners = scene.vertices[faces.reshape(-1)].astype(float)
    centre = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    reach = np.linalg.norm(corners - centre, axis=1).max()
    return np.array([*centre, reach + 0.01])


def _near(rays: Rays, distance: Float32s, body: MovingBody, sphere: Floats) -> NDArray[np.intp]:
    """Rays that may meet a body before what they have met, shape (k,)."""
    # The farthest way of the sphere's centre during the turn widens it.
    longest = float(np.abs(rays.seconds).max(initial=0.0))
    offset = np.hypot(*(sphere[:2] - body.pose[:2]))
    way = (abs(body.motion.speed) + abs(body.motion.turn_rate) * offset) * longest
    marks = np.zeros(len(distance), np.bool_)
    centre, radius = sphere[:3].astype(np.float32), np.float32(sphere[3] + way)
    _mark_near(rays.origins, rays.directions, distance, centre, radius, marks)
    return np.flatnonzero(marks)


def _as_seen(body: MovingBody, rays: Rays) -> tuple[Float32s, Float32s, Float32s]:
    """Rays, turned and shifted such that they meet the body at rest where they meet it moving."""
    x, y, heading = body.pose
    ahead, left, turned = body.motion.after(rays.seconds)
    moved_x = x + ahead * np.cos(heading) - left * np.sin(heading)
    moved_y = y + ahead * np.sin(heading) + left * np.cos(heading)
    cos, sin = np.cos(turned), np.sin(turned)

    def back(east: Floats, north: Floats) -> tuple[Floats, Floats]:
        return cos * east + sin * north, cos * north - sin * east

    origins, directions = rays.origins.astype(float), rays.directions.astype(float)
    east, north = back(origins[:, 0] - moved_x, origins[:, 1] - moved_y)
    origins[:, 0], origins[:, 1] = x + east, y + north
    directions[:, 0], directions[:, 1] = back(directions[:, 0], directions[:, 1])
    return origins.astype(np.float32), directions.astype(np.float32), rays.seconds


@kernel()
def _mark_near(origins, directions, distance, centre, radius, marks):  # type: ignore[no-untyped-def]
    """Mark rays that pass through a sphere, and have met nothing before it; in place."""
    for i in range(len(distance)):
        x, y, z = (
            centre[0] - origins[i, 0],
            centre[1] - origins[i, 1],
            centre[2] - origins[i, 2],
        )
        along = x * directions[i, 0] + y * directions[i, 1] + z * directions[i, 2]
        aside = x * x + y * y + z * z - along * along
        marks[i] = aside < radius * radius and -radius < along < distance[i] + radius
