"""Standing and sitting: what people do with their legs and hands when they do not walk."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.models.people.skeleton import Posture

# Wrists of (hand, other hand) relative to the base of the neck: forward, outward, up, in body
# heights; None for an arm that hangs.
_HANDS: dict[str, tuple[tuple[float, float, float] | None, ...]] = {
    "hanging": (None, None),
    "pocket": ((0.025, 0.125, -0.285), None),
    "pockets": ((0.025, 0.125, -0.285), (0.025, 0.125, -0.285)),
    "phone": ((0.165, 0.030, -0.120), None),
    "calling": ((0.072, 0.108, -0.018), None),
    "crossed": ((0.100, -0.050, -0.135), (0.112, -0.040, -0.115)),
    "strap": ((0.075, 0.075, -0.085), None),
    "hip": ((-0.010, 0.130, -0.235), None),
    "talking": ((0.190, 0.130, -0.130), (0.130, 0.060, -0.170)),
    "folded": ((0.110, 0.010, -0.270), (0.115, 0.015, -0.255)),
    "behind": ((-0.085, 0.020, -0.270), (-0.090, 0.015, -0.255)),
    "lap": ((0.200, 0.050, -0.215), (0.215, 0.070, -0.225)),
    "table": ((0.210, 0.060, -0.120), (0.190, 0.030, -0.135)),
}
STANDING = ("pockets", "hanging", "pocket", "hip", "calling", "behind", "crossed")
REACHING = ("phone", "talking", "crossed", "folded", "talking")
WALKING = ("hanging",) * 11 + ("pocket", "phone", "calling")
SITTING = ("lap", "table", "phone", "lap", "crossed")


def standing(rng: np.random.Generator, room: float) -> Posture:
    """Weight on one leg, the other one relaxed and more or less in front.

    Args:
        rng: The source of chance.
        room: Length of ground that is stood on, in body heights.
    """
    weight = int(rng.integers(2))
    relaxed = 1 - weight
    ahead = float(np.clip(1.2 * (room - 0.28), -0.05, 0.30) + rng.uniform(-0.05, 0.05))
    thigh, knee, spread, out = (np.zeros(2) for _ in range(4))
    knee[:] = 0.04
    knee[relaxed] = 0.16 + 0.2 * float(rng.random())
    thigh[relaxed] = ahead + 0.5 * knee[relaxed]
    thigh[weight] = -0.03 - 0.4 * ahead
    spread[:] = 0.04
    spread[relaxed] = 0.06 + 0.06 * float(rng.random())
    out[:] = rng.uniform(0.1, 0.35, 2)
    way = 1.0 if weight else -1.0
    return Posture(
        thigh=thigh,
        spread=spread,
        knee=knee,
        ankle=knee - thigh,
        arm=rng.uniform(-0.05, 0.12, 2),
        arm_spread=rng.uniform(0.10, 0.16, 2),
        elbow=rng.uniform(0.15, 0.4, 2),
        lean=float(rng.uniform(-0.03, 0.03)),
        pelvis_turn=float(rng.uniform(-0.12, 0.12)),
        chest_turn=float(rng.uniform(-0.15, 0.15)),
        pelvis_drop=0.10 * way,
        sway=0.016 * way,
        toe_out=out,
        head_turn=float(rng.uniform(-0.6, 0.6)),
        nod=float(rng.uniform(0.0, 0.12)),
    )


def sitting(rng: np.random.Generator) -> Posture:
    """Upright on a chair, feet on the ground."""
    thigh = rng.uniform(1.38, 1.46, 2)
    knee = thigh + rng.uniform(-0.25, 0.12, 2)
    return Posture(
        thigh=thigh,
        spread=rng.uniform(0.02, 0.16, 2),
        knee=knee,
        ankle=knee - thigh,
        lean=float(rng.uniform(-0.12, 0.08)),
        stoop=0.2,
        chest_turn=float(rng.uniform(-0.1, 0.1)),
        head_turn=float(rng.uniform(-0.5, 0.5)),
        nod=float(rng.uniform(0.0, 0.25)),
    )


def holding(posture: Posture, gesture: str, side: int) -> Posture:
    """The same posture with hands in pockets, at a telephone, folded and so on.

    Args:
        posture: Posture of the rest of the body.
        gesture: Gesture of the hands: one of `STANDING`, `REACHING`, `WALKING`, `SITTING`, or
            "strap".
        side: Side of the busy hand if there is only one: 0 right, 1 left.
    """
    hands: Floats = posture.hands.copy()
    for hand, place in zip((side, 1 - side), _HANDS[gesture], strict=True):
        if place is not None:
            hands[hand] = place
    looking = {"phone": 0.35, "lap": 0.15}.get(gesture, 0.0)
    return replace(posture, hands=hands, nod=posture.nod + looking)


def carrying(posture: Posture, side: int) -> Posture:
    """The same posture with a weight in one hand, which hardly swings."""
    arm, elbow = posture.arm.copy(), posture.elbow.copy()
    arm[side] *= 0.35
    elbow[side] = 0.12 + 0.2 * elbow[side]
    return replace(posture, arm=arm, elbow=elbow)
