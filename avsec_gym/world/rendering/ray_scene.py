"""All meshes of a scene as one, ready for rays (embree) and for the shading kernels."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.mesh import Float32s, Int32s, Mesh, merge
from avsec_gym.world.section import Surface
from avsec_gym.world.textures.library import texture_library

NOTHING = -1
"""Object id of the scenery, and of the sky."""
NO_OVERLAY = np.float32(-1e8)
"""Overlay coordinates of surfaces without an overlay; the kernels cannot compare with NaN."""


class Thing(NamedTuple):
    """A mesh in the world frame, and what it is."""

    mesh: Mesh
    surface: Surface
    object_id: int = NOTHING


class MaterialTable(NamedTuple):
    """The materials of a scene as arrays, M of them; see `avsec_gym.world.material.Material`."""

    texture: Int32s
    tint: Float32s
    mirror: Float32s
    glass: NDArray[np.bool_]
    translucent: Float32s
    leaves: NDArray[np.bool_]
    grainy: NDArray[np.bool_]
    infrared: Float32s
    """-1: the texture's brightness."""
    glow: Float32s
    clear: Float32s
    flakes: Float32s


class Hits(NamedTuple):
    """What n rays hit first."""

    face: Int32s
    """-1 for none, shape (n,)."""
    distance: Float32s
    """Metres, infinite for none, shape (n,)."""
    u: Float32s
    v: Float32s
    """Barycentric coordinates, shape (n,)."""

    def of(self, which: NDArray[np.intp]) -> Hits:
        """Those of some of the rays."""
        return Hits(self.face[which], self.distance[which], self.u[which], self.v[which])


class RayScene:
    """Triangles with their materials, objects and surfaces, in embree's hierarchy.

    Args:
        things: Meshes in the world frame.
    """

    def __init__(self, things: Sequence[Thing]) -> None:
        mesh = merge([thing.mesh for thing in things])
        counts = [len(thing.mesh.faces) for thing in things]
        self.vertices = np.ascontiguousarray(mesh.vertices, np.float32)
        self.normals = np.ascontiguousarray(mesh.normals, np.float32)
        self.uv = np.ascontiguousarray(mesh.uv, np.float32)
        self.faces = np.ascontiguousarray(mesh.faces, np.int32)
        self.overlay_uv = (
            np.zeros((0, 2), np.float32)
            if mesh.overlay_uv is None
            else np.nan_to_num(mesh.overlay_uv, nan=float(NO_OVERLAY))
        )
        self.material = np.ascontiguousarray(mesh.material, np.int32)
        self.materials = _table(mesh)
        self.object_id = np.repeat(np.array([t.object_id for t in things], np.int32), counts)
        self.surface = np.repeat(np.array([t.surface for t in things], np.uint8), counts)

    @cached_property
    def _embree(self) -> Any:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        _start_embree()
        scene = EmbreeScene()
        TriangleMesh(scene, self.vertices, self.faces)
        return scene

    def hits(self, origins: Float32s, directions: Float32s) -> Hits:
        """First hits of rays.

        Args:
            origins: Origins of the rays, shape (n, 3), contiguous float32.
            directions: Unit vectors along the rays, shape (n, 3), contiguous float32.
        """
        if len(origins) == 0:
            none = np.zeros(0, np.float32)
            return Hits(np.zeros(0, np.int32), none, none, none)
        found = self._embree.run(origins, directions, query="INTERSECT", output=True)
        found["tfar"][found["primID"] < 0] = np.inf
        return Hits(found["primID"], found["tfar"], found["u"], found["v"])

    def blocked(self, origins: Float32s, directions: Float32s) -> NDArray[np.bool_]:
        """Whether anything is in the way, shape (n,)."""
        if len(origins) == 0:
            return np.zeros(0, bool)
        return np.asarray(self._embree.run(origins, directions, query="OCCLUDED") >= 0)


@cache
def _start_embree() -> None:
    """Have embree build its hierarchies with one thread.

    With several their order is not quite the same each time, and with it which of two triangles
    is hit by a ray through their common edge.  Embree asks for the processors when it starts.
    """
    if not hasattr(os, "sched_setaffinity"):
        return
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    processors = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(processors)})
    try:
        scene = EmbreeScene()
        TriangleMesh(scene, np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32))
        scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))
    finally:
        os.sched_setaffinity(0, processors)


def _table(mesh: Mesh) -> MaterialTable:
    library = texture_library()
    materials = mesh.materials

    def column(name: str) -> Float32s:
        return np.array([getattr(material, name) for material in materials], np.float32)

    return MaterialTable(
        texture=np.array([library.index(material.texture) for material in materials], np.int32),
        tint=column("tint"),
        mirror=column("mirror"),
        glass=np.array([material.glass for material in materials]),
        translucent=column("translucent"),
        leaves=np.array([material.leaves for material in materials]),
        grainy=np.array([material.grainy for material in materials]),
        infrared=np.array(
            [-1.0 if m.infrared is None else m.infrared for m in materials], np.float32
        ),
        glow=column("glow"),
        clear=column("clear"),
        flakes=column("flakes"),
    )
