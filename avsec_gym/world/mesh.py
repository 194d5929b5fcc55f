"""Triangle meshes: what everything in the world is made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from avsec_gym.world.material import Material

Float32s = NDArray[np.float32]
Int32s = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Mesh:
    """V vertices and F triangles.

    Objects have x forward, y left, z up, and the origin at the centre of their bottom.

    Args:
        vertices: Positions of the vertices, shape (V, 3), metres.
        normals: Outward normals for shading, shape (V, 3), unit length.  A hard edge has its
            vertices twice.
        uv: Place of each vertex on its texture, shape (V, 2), **metres** from the texture's top
            left corner, to the right and down; textures know their size and repeat.
        faces: Vertex indices, shape (F, 3), counter-clockwise seen from outside.
        material: Index into `materials` for each face, shape (F,).
        materials: Materials of the surfaces.
        overlay_uv: Place of each vertex on the scene's overlay (road paint, cracks, stains), shape
            (V, 2), metres along the road and to the left; NaN where there is none.
    """

    vertices: Float32s
    normals: Float32s
    uv: Float32s
    faces: Int32s
    material: Int32s
    materials: tuple[Material, ...]
    overlay_uv: Float32s | None = None

    def placed(self, x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> Mesh:
        """Turned about z by `yaw`, then moved."""
        cos, sin = np.cos(yaw), np.sin(yaw)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]], np.float32)
        vertices = self.vertices @ turn + np.array([x, y, z], np.float32)
        return replace(self, vertices=vertices, normals=self.normals @ turn)

    def turned(self, rotation: ArrayLike) -> Mesh:
        """Turned about the origin by a rotation matrix, shape (3, 3)."""
        turn = np.asarray(rotation, np.float32).T
        return replace(self, vertices=self.vertices @ turn, normals=self.normals @ turn)

    def scaled(self, x: float, y: float, z: float) -> Mesh:
        """Stretched along the axes (positive factors); textures stretch with it."""
        factors = np.array([x, y, z], np.float32)
        normals = self.normals / factors
        normals /= np.linalg.norm(normals, axis=1, keepdims=True) + np.float32(1e-12)
        return replace(self, vertices=self.vertices * factors, normals=normals)

    def mirrored(self) -> Mesh:
        """The left side from the right one: y changes sign, outside stays outside."""
        flip = np.array([1.0, -1.0, 1.0], np.float32)
        return replace(
            self,
            vertices=self.vertices * flip,
            normals=self.normals * flip,
            faces=np.ascontiguousarray(self.faces[:, ::-1]),
        )

    def with_material(self, material: Material, index: int = 0) -> Mesh:
        """One of its materials exchanged."""
        materials = (*self.materials[:index], material, *self.materials[index + 1 :])
        return replace(self, materials=materials)

    @property
    def bounds(self) -> tuple[Float32s, Float32s]:
        """Lowest and highest coordinates, each of shape (3,)."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    def fitted(self, length: float, width: float, height: float) -> Mesh:
        """Stretched and moved to fill a box exactly: bottom centre at the origin."""
        low, high = self.bounds
        centre = np.array([*(0.5 * (low + high))[:2], low[2]], np.float32)
        factors = np.array([length, width, height], np.float32) / (high - low)
        return replace(self, vertices=self.vertices - centre).scaled(*factors.tolist())


def merge(meshes: Sequence[Mesh]) -> Mesh:
    """All meshes as one; equal materials become one."""
    index: dict[Material, int] = {}
    vertices_before = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    materials = []
    for mesh in meshes:
        codes = [index.setdefault(material, len(index)) for material in mesh.materials]
        materials.append(np.array(codes, np.int32)[mesh.material])
    overlaid = any(mesh.overlay_uv is not None for mesh in meshes)
    return Mesh(
        vertices=np.concatenate([mesh.vertices for mesh in meshes]),
        normals=np.concatenate([mesh.normals for mesh in meshes]),
        uv=np.concatenate([mesh.uv for mesh in meshes]),
        faces=np.concatenate(
            [
                mesh.faces + np.int32(before)
                for mesh, before in zip(meshes, vertices_before[:-1], strict=True)
            ]
        ),
        material=np.concatenate(materials),
        materials=tuple(index),
        overlay_uv=np.concatenate([_overlay(mesh) for mesh in meshes]) if overlaid else None,
    )


def _overlay(mesh: Mesh) -> Float32s:
    if mesh.overlay_uv is not None:
        return mesh.overlay_uv
    return np.full((len(mesh.vertices), 2), np.nan, np.float32)
