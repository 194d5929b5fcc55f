"""Where laser pulses end in a scene, and how much of their light comes back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from avsec_gym.world.mesh import Float32s, Int32s
from avsec_gym.world.rendering.laser import laser_reflectance
from avsec_gym.world.rendering.ray_scene import NOTHING
from avsec_gym.world.rendering.renderer import Renderer

_PULSE_ANGLE = 0.003
"""Width of a laser pulse, radians."""


class Echoes(NamedTuple):
    """What n laser pulses met."""

    distance: Float32s
    """Metres, infinite for none, shape (n,)."""
    reflectance: Float32s
    """In the infrared, [0, 1], shape (n,)."""
    cosine: Float32s
    """Of the angle of incidence, shape (n,)."""
    object_id: Int32s
    """Shape (n,)."""


def laser_echoes(renderer: Renderer, origins: Float32s, directions: Float32s) -> Echoes:
    """Where laser pulses end; they pass one pane of glass without an echo.

    Args:
        renderer: Renderer of the scene.
        origins: Origins of the pulses, metres, shape (n, 3).
        directions: Unit vectors along the pulses, shape (n, 3).
    """
    scene = renderer.scene
    hits = renderer.hits(origins, directions, _PULSE_ANGLE, layers=1)
    face, distance = hits.face.copy(), hits.distance.copy()
    materials = scene.materials
    glass = np.flatnonzero((face >= 0) & materials.glass[scene.material[face]])
    if len(glass):
        passed = distance[glass] + np.float32(0.01)
        starts = origins[glass] + passed[:, None] * directions[glass]
        behind = scene.hits(np.ascontiguousarray(starts), directions[glass].copy())
        again = behind.face >= 0
        again &= ~materials.glass[scene.material[np.maximum(behind.face, 0)]]
        face[glass] = np.where(again, behind.face, -1)
        distance[glass] = np.where(again, behind.distance + passed, np.inf)
    seen = face >= 0
    reflectance, cosine = np.zeros_like(distance), np.zeros_like(distance)
    laser_reflectance(renderer.arrays, face, distance, origins, directions, reflectance, cosine)
    objects = np.where(seen, scene.object_id[np.maximum(face, 0)], NOTHING)
    return Echoes(distance, reflectance, cosine, objects)
