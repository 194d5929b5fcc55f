"""Pedestrians and people who sit."""

from __future__ import annotations

import numpy as np

from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.people.body import body
from avsec_gym.world.models.people.clothing import Outfit, dressed
from avsec_gym.world.models.people.gait import walking as walking_posture
from avsec_gym.world.models.people.luggage import luggage
from avsec_gym.world.models.people.postures import (
    REACHING,
    SITTING,
    STANDING,
    WALKING,
    carrying,
    holding,
    sitting,
    standing,
)
from avsec_gym.world.models.people.rings import Rings, rods, sweep
from avsec_gym.world.models.people.skeleton import Posture, Skeleton, pose
from avsec_gym.world.models.people.skin import filling


def make_person(
    category: str,
    dimensions: tuple[float, float, float],
    appearance: int,
    phase: float = 0.0,
    walking: bool = True,
) -> Mesh:
    """A person on foot or on a chair, who fills a box.

    Args:
        category: "Pedestrian" or "Person_sitting".
        dimensions: Height, width, length of the box, metres.
        appearance: Number of the person, 0 or more: build, clothes, luggage, habits.
        phase: Phase of the gait cycle, in [0, 1); it advances by 1 with each `stride_length`.
        walking: Otherwise standing.  Who sits does neither.

    Raises:
        ValueError: Another category.
    """
    height, width, length = dimensions
    if category == "Person_sitting":
        stature = height / 0.775
        outfit = dressed(appearance, stature, seated=True)
        skeleton = pose(_seated(appearance, outfit), stature)
        return filling([*body(skeleton, outfit), *_chair(skeleton, appearance)], dimensions)
    if category != "Pedestrian":
        raise ValueError(f"people are Pedestrian or Person_sitting, got {category!r}")
    outfit = dressed(appearance, height)
    breadth = float(np.clip(width / height / 0.34, 0.88, 1.14))
    posture = _habit(appearance, outfit, walking, phase, length / height)
    skeleton = pose(posture, height, breadth)
    return filling([*body(skeleton, outfit), *luggage(skeleton, outfit)], dimensions)


def _habit(appearance: int, outfit: Outfit, walking: bool, phase: float, room: float) -> Posture:
    """The gesture of a person, the same for every call."""
    rng = np.random.Generator(np.random.PCG64((appearance, 1)))
    hurry = float(np.clip(4.0 * (room - 0.5), 0.0, 1.0))
    posture = walking_posture(phase, hurry) if walking else standing(rng, room)
    if outfit.luggage in ("handbag", "shopping bag"):
        return carrying(posture, outfit.side)
    gestures = WALKING if walking else REACHING if room > 0.36 else STANDING
    gesture = gestures[rng.integers(len(gestures))]
    if outfit.luggage == "backpack" and gesture == "hanging" and rng.random() < 0.4:
        gesture = "strap"
    return holding(posture, gesture, 1 - outfit.side)


def _seated(appearance: int, outfit: Outfit) -> Posture:
    rng = np.random.Generator(np.random.PCG64((appearance, 2)))
    return holding(sitting(rng), SITTING[rng.integers(len(SITTING))], outfit.side)


def _chair(skeleton: Skeleton, appearance: int) -> list[Rings]:
    """A café chair under the person."""
    wood = Material(
        tint=((0.16, 0.10, 0.06), (0.05, 0.05, 0.055), (0.45, 0.44, 0.42))[appearance % 3],
        infrared=0.4,
    )
    height = skeleton.height
    hips = skeleton.spine[0]
    top = hips[2] - 0.070 * height
    middle, half = hips[0] + 0.055 * height, 0.115 * height
    corners = np.array([(-half, -half), (-half, half), (half, -half), (half, half)])
    feet = np.c_[corners * 1.08 + [middle, hips[1]], np.zeros(4)]
    heads = np.c_[corners * 0.92 + [middle, hips[1]], np.full(4, top)]
    posts = heads[:2] + np.array([-0.05 * height, 0.0, 0.26 * height])
    bars = rods(
        np.concatenate([feet, heads[:2]]), np.concatenate([heads, posts]), 0.011, wood, sides=4
    )
    plate = np.array([(middle, hips[1], top - 0.03), (middle, hips[1], top)])
    seat = sweep(plate, (0, 0, 1), (1, 0, 0), (half, half, half), wood, squareness=0.8)
    rest = posts.mean(axis=0) - [[0, 0, 0.11 * height], [0, 0, 0.0]]
    back = sweep(rest, (0, 0, 1), (1, 0, 0), (0.012, 0.012, half), wood, squareness=0.8)
    return [bars, seat, back]
