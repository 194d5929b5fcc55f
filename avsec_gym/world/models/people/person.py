"""Pedestrians and people who sit."""

from __future__ import annotations

from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.people.body import body
from avsec_gym.world.models.people.clothing import dressed
from avsec_gym.world.models.people.gait import walking as walking_posture
from avsec_gym.world.models.people.rings import filling
from avsec_gym.world.models.people.skeleton import pose


def make_person(category, dimensions, appearance, phase, walking) -> Mesh:
    height, width, _ = dimensions
    outfit = dressed(appearance, height)
    posture = walking_posture(phase)
    skeleton = pose(posture, height)
    return filling(body(skeleton, outfit), dimensions)
