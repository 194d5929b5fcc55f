"""Cyclists: a rider on a bicycle, pedalling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.people.bicycle import chosen_bicycle, stretching
from avsec_gym.world.models.people.bicycle_parts import Bicycle, bicycle_parts
from avsec_gym.world.models.people.body import body
from avsec_gym.world.models.people.clothing import dressed
from avsec_gym.world.models.people.luggage import luggage
from avsec_gym.world.models.people.rings import unit
from avsec_gym.world.models.people.skeleton import (
    SIDES,
    Posture,
    Skeleton,
    pose,
    reach,
    turn_y,
)
from avsec_gym.world.models.people.skin import filling, grouped

_LIMITS = ((-0.3, 0.3), (-0.08, 0.12), (-0.2, 0.2))


def make_cyclist(
    dimensions: tuple[float, float, float], appearance: int, phase: float = 0.0
) -> Mesh:
    """A rider on a bicycle, who fill a box.

    Args:
        dimensions: Height, width, length of the box, metres.
        appearance: Number of the rider and bicycle, 0 or more.
        phase: Revolutions of the cranks; at 0 the right pedal is on top.
    """
    stature = float(np.clip(dimensions[0], 1.45, 1.95))
    outfit = dressed(appearance, stature, seated=True)
    rng = np.random.Generator(np.random.PCG64((appearance, 4)))
    if outfit.hat == "hat" or rng.random() < 0.3:
        outfit = replace(outfit, hat="helmet")
    bicycle = chosen_bicycle(appearance, saddle=0.51 * stature + 0.04)
    rider = riding(bicycle, stature, phase)
    people = [*body(rider, outfit), *luggage(rider, outfit)]
    parts = [*people, *bicycle_parts(bicycle, phase)]
    top = float(rider.spine[3, 2])
    loose = [
        stretching(part, 0.5 * bicycle.wheelbase, bicycle.saddle, top) for part in grouped(parts)
    ]
    return filling(loose, dimensions, _LIMITS)


def riding(bicycle: Bicycle, stature: float, phase: float) -> Skeleton:
    """The skeleton of a person on a bicycle: seat on the saddle, feet and hands where they belong.

    Args:
        bicycle: The bicycle.
        stature: Stature of the rider, metres.
        phase: Revolutions of the cranks.
    """
    lean = 0.55 if bicycle.sporty else 0.26
    rider = pose(Posture(lean=lean, stoop=0.35, nod=0.0), stature)
    size = rider.size
    shift = bicycle.seat + np.array([-0.03, 0.0, 0.052 * stature]) - rider.spine[0]
    spine, legs, arms = rider.spine + shift, rider.legs + shift, rider.arms + shift
    swing = np.sin(2.0 * np.pi * (phase + np.array([0.0, 0.5])))
    pitch = -0.22 + 0.12 * swing
    pedals = bicycle.pedals(phase)
    for side in range(2):
        sole = np.array([-0.40 * size.foot, 0.0, size.ankle + 0.011])
        ankle = pedals[side] + turn_y(-pitch[side]) @ sole - [0.0, 0.015 * SIDES[side], 0.0]
        bend = np.array([1.0, 0.12 * SIDES[side], 0.3])
        legs[side, 1] = reach(legs[side, 0], ankle, size.thigh, size.shank, bend)
        legs[side, 2] = ankle
        grip = bicycle.hands[side]
        way = unit(grip - arms[side, 0])
        wrist = grip - 0.046 * stature * way + [0.0, 0.0, 0.016]
        bend = np.array([-0.2, 0.8 * SIDES[side], -0.7])
        arms[side, 1] = reach(arms[side, 0], wrist, size.upper_arm, size.forearm, bend)
        arms[side, 2] = wrist
    still = np.zeros_like(legs)
    return replace(
        rider,
        spine=spine,
        legs=legs,
        arms=arms,
        foot_pitch=pitch,
        foot_turn=0.05 * SIDES,
        leg_give=still,
        arm_give=still,
    )
