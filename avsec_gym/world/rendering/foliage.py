"""Single leaves on the triangles that stand for sprays of them.

A triangle of foliage is seen as two layers of leaves, one in each cell of a lattice on its texture.
Rays pass between the leaves.  Far away the cells grow, so that they never get smaller than a
few pixels.
"""

from __future__ import annotations

import numpy as np

from avsec_gym.kernels import kernel

_ONE, _HALF = np.float32(1.0), np.float32(0.5)
_LEAF = np.float32(0.085)
"""Size of a cell near by, metres."""
_PIXELS = np.float32(2.6)
"""Smallest size of a cell in an image, pixels."""


@kernel(error_model="numpy")
def leaf_cell(distance, pixel_angle):
    """Size of the cells at a distance, metres: the finest one doubled until it can be seen."""
    needed = distance * pixel_angle * _PIXELS
    size = _LEAF
    while size < needed:
        size *= np.float32(2.0)
    return size


@kernel(inline="always", error_model="numpy")
def _chance(column, row, layer):
    """32 well-mixed bits for a cell."""
    bits = np.uint32(column) * np.uint32(0x9E3779B1) ^ np.uint32(row) * np.uint32(0x85EBCA77)
    bits ^= np.uint32(layer) * np.uint32(0xC2B2AE3D)
    bits ^= bits >> np.uint32(15)
    bits *= np.uint32(0x2C1B3C6D)
    bits ^= bits >> np.uint32(12)
    bits *= np.uint32(0x297A2D39)
    bits ^= bits >> np.uint32(15)
    return bits


@kernel(error_model="numpy")
def leaf_at(u, v, size):
    """The leaf at a place on the texture: 32 bits of its own, 0 where there is none.

    Invariant: the bits depend on the cell and the layer alone, so that a leaf looks the same from
    every camera; the lowest bit is set, so that no leaf is 0.

    Args:
        u: Place on the texture, metres to the right.
        v: Place on the texture, metres down.
        size: Size of the cells, metres.
    """
    for layer in range(2):
        shift = _HALF * np.float32(layer)
        x, y = u / size + shift, v / size + shift
        column, row = np.int32(np.floor(x)), np.int32(np.floor(y))
        bits = _chance(column, row, layer + 1)
        # An ellipse somewhere in the cell, turned by chance.
        fx = x - np.float32(column) - np.float32(0.38 + 0.24 * ((bits & 0xFF) / 255.0))
        fy = y - np.float32(row) - np.float32(0.38 + 0.24 * (((bits >> 8) & 0xFF) / 255.0))
        diagonal = _ONE if (bits >> 16) & 1 else -_ONE
        if fx * fx + fy * fy - np.float32(0.9) * diagonal * fx * fy < np.float32(0.13):
            return bits | np.uint32(1)
    return np.uint32(0)


@kernel(error_model="numpy")
def between_leaves(scene, faces, distances, us, vs, pixel_angle, gaps):
    """Mark the hits on foliage that go between its leaves.

    Args:
        scene: `SceneArrays`.
        faces: Faces that were hit, -1 for none, shape (n,).
        distances: Distances of the hits, metres, shape (n,).
        us: Barycentric coordinates of the faces' second corners, shape (n,).
        vs: Barycentric coordinates of the third corners, shape (n,).
        pixel_angle: Angle between neighbouring rays, radians.
        gaps: Whether each hit is a gap, bool, shape (n,): set by this function.
    """
    for i in range(len(faces)):
        face = faces[i]
        # Invariant: the gaps of the hits before i are marked, those behind it are as they came.
        gaps[i] = False
        if face < 0 or not scene.materials.leaves[scene.material[face]]:
            continue
        a, b, c = scene.faces[face, 0], scene.faces[face, 1], scene.faces[face, 2]
        first = _ONE - us[i] - vs[i]
        u = first * scene.uv[a, 0] + us[i] * scene.uv[b, 0] + vs[i] * scene.uv[c, 0]
        v = first * scene.uv[a, 1] + us[i] * scene.uv[b, 1] + vs[i] * scene.uv[c, 1]
        size = leaf_cell(distances[i], pixel_angle)
        gaps[i] = leaf_at(u, v, size) == np.uint32(0)
