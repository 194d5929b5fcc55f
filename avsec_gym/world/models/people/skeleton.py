"""The human skeleton: joint angles and hand targets in, joint positions out."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats
from avsec_gym.world.models.people.rings import unit

SIDES = np.array([-1.0, 1.0])
"""Sides of the pairs in this package: the right one first; y points to the left."""


def _pair(right: float, left: float | None = None) -> Floats:
    return np.array([right, right if left is None else left])


@dataclass(frozen=True, eq=False)
class Posture:
    """The posture of a standing, walking or sitting person; radians, pairs are (right, left).

    Args:
        thigh: Angle of the thighs forward from straight down.
        spread: Angle of the legs outwards.
        knee: Flexion of the knees, 0 for a straight leg.
        ankle: Toes up from the right angle between foot and shank.
        arm: Upper arm forward from straight down.
        arm_spread: Outwards.
        elbow: Flexion of the elbows, 0 for a straight arm.
        hands: Places of the hands relative to the base of the neck: forward, outward and up in the
            chest's frame, in body heights, shape (2, 3); NaN for an arm that hangs by its angles.
        lean: Angle of the back, forwards.
        stoop: More of it towards the neck.
        pelvis_turn: Turn of the pelvis to the left, seen from above.
        chest_turn: Turn of the chest to the left.
        pelvis_drop: Roll of the pelvis: the left hip is higher than the right one.
        sway: Pelvis to the left, in body heights.
        toe_out: Turn of the feet, outwards.
        head_turn: Turn of the head to the left.
        nod: Angle of the head, downwards.
    """

    thigh: Floats = field(default_factory=lambda: _pair(0.0))
    spread: Floats = field(default_factory=lambda: _pair(0.0))
    knee: Floats = field(default_factory=lambda: _pair(0.05))
    ankle: Floats = field(default_factory=lambda: _pair(0.05))
    arm: Floats = field(default_factory=lambda: _pair(0.05))
    arm_spread: Floats = field(default_factory=lambda: _pair(0.12))
    elbow: Floats = field(default_factory=lambda: _pair(0.25))
    hands: Floats = field(default_factory=lambda: np.full((2, 3), np.nan))
    lean: float = 0.03
    stoop: float = 0.12
    pelvis_turn: float = 0.0
    chest_turn: float = 0.0
    pelvis_drop: float = 0.0
    sway: float = 0.0
    toe_out: Floats = field(default_factory=lambda: _pair(0.14))
    head_turn: float = 0.0
    nod: float = 0.05


@dataclass(frozen=True)
class Proportions:
    """Lengths of the body's parts, metres (adults after Drillis and Contini; children differ)."""

    height: float
    breadth: float = 1.0

    @property
    def childlike(self) -> float:
        """0 for adults, 1 for small children."""
        return float(np.clip((1.52 - self.height) / 0.45, 0.0, 1.0))

    @property
    def head(self) -> float:
        """Chin to crown."""
        return (0.131 + 0.035 * self.childlike) * self.height

    @property
    def thigh(self) -> float:
        """Hip to knee."""
        return (0.245 - 0.012 * self.childlike) * self.height

    @property
    def shank(self) -> float:
        """Knee to ankle."""
        return (0.240 - 0.014 * self.childlike) * self.height

    @property
    def ankle(self) -> float:
        """Ankle above the sole, shoe included."""
        return 0.048 * self.height

    @property
    def trunk(self) -> float:
        """Hip joints to the base of the neck, along the spine."""
        return (0.312 - 0.010 * self.childlike) * self.height

    @property
    def upper_arm(self) -> float:
        """Shoulder to elbow."""
        return 0.180 * self.height

    @property
    def forearm(self) -> float:
        """Elbow to wrist."""
        return 0.148 * self.height

    @property
    def foot(self) -> float:
        """Length of the shoe."""
        return 0.160 * self.height


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Joint positions in metres; x forward, y left, z up, the soles' lowest point at z = 0.

    Args:
        size: The lengths of its parts.
        spine: Hips' centre, waist, chest, base of the neck, shape (4, 3).
        facing: Forward direction at each of them, shape (4, 3).
        legs: Hip, knee and ankle of both sides, shape (2, 3, 3).
        arms: Shoulder, elbow and wrist of both sides, shape (2, 3, 3).
        foot_pitch: Toes up, shape (2,), radians.
        foot_turn: Turn of the feet to the left, shape (2,), radians.
        head: Rotation from the head's frame, shape (3, 3).
        leg_give: Displacement of the joints of the legs when the body is loosened, shape (2, 3, 3).
        arm_give: The same for the arms.
    """

    size: Proportions
    spine: Floats
    facing: Floats
    legs: Floats
    arms: Floats
    foot_pitch: Floats
    foot_turn: Floats
    head: Floats
    leg_give: Floats
    arm_give: Floats

    @property
    def height(self) -> float:
        """Stature when upright, metres."""
        return self.size.height


def pose(posture: Posture, height: float, breadth: float = 1.0) -> Skeleton:
    """A skeleton in a posture, standing on the ground.

    Args:
        posture: The joint angles.
        height: Stature when upright, metres.
        breadth: Breadth of shoulders and hips, relative to the usual one.
    """
    size = Proportions(height, breadth)
    spine, facing = _spine(posture, size)
    hip_turn = turn_z(posture.pelvis_turn)
    half = 0.050 * height * breadth * SIDES
    hips = spine[0] + np.stack([0.0 * half, half, half * posture.pelvis_drop], axis=1) @ hip_turn.T
    thigh = _hanging(posture.thigh, posture.spread)
    shank = _hanging(posture.thigh - posture.knee, posture.spread)
    knees = hips + size.thigh * thigh
    ankles = knees + size.shank * shank
    legs = np.stack([hips, knees, ankles], axis=1)
    pitch = posture.thigh - posture.knee + posture.ankle
    arms, reaching = _arms(posture, size, spine, facing)
    ground = (ankles[:, 2] - sole_depth(pitch, size)).min()
    for part in (spine, legs, arms):
        part[..., 2] -= ground
    return Skeleton(
        size,
        spine,
        facing,
        legs,
        arms,
        pitch,
        posture.pelvis_turn + SIDES * posture.toe_out,
        turn_z(posture.chest_turn * 0.4 + posture.head_turn) @ turn_y(posture.nod),
        _leg_give(legs, spine),
        _arm_give(arms, size, reaching),
    )


def sole_depth(pitch: Floats, size: Proportions) -> Floats:
    """How far the lowest point of the shoe lies below the ankle, for a pitch of the foot."""
    heel = 0.27 * size.foot * np.sin(pitch) + size.ankle * np.cos(pitch)
    ball = -0.44 * size.foot * np.sin(pitch) + size.ankle * np.cos(pitch)
    return np.maximum(heel, ball)


def reach(root: Floats, target: Floats, first: float, second: float, bend: ArrayLike) -> Floats:
    """The middle joint of a two-bone limb from `root` to `target`, both of shape (3,).

    Args:
        root: Shoulder or hip.
        target: Wrist or ankle; if it is too far, it is moved within reach, in place.
        first: Length of the upper bone, metres.
        second: Length of the lower bone.
        bend: Direction in which the elbow or knee points.
    """
    way = target - root
    distance = float(np.linalg.norm(way))
    longest = 0.995 * (first + second)
    if distance > longest:
        target[:] = root + way * (longest / distance)
        distance = longest
    along = way / max(distance, 1e-6)
    foot = (first**2 - second**2 + distance**2) / (2.0 * max(distance, 1e-6))
    pole = np.asarray(bend, float)
    pole = unit(pole - (pole @ along) * along)
    return np.asarray(root + foot * along + np.sqrt(max(first**2 - foot**2, 0.0)) * pole)


def turn_z(angle: float) -> Floats:
    """Rotation about the vertical, to the left."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def turn_y(angle: float) -> Floats:
    """Rotation about the left axis: forwards and down."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])


def _spine(posture: Posture, size: Proportions) -> tuple[Floats, Floats]:
    shares = np.array([0.30, 0.36, 0.34]) * size.trunk
    tilt = posture.lean + posture.stoop * np.array([-0.6, 0.0, 1.0])
    sway = posture.sway * size.height
    steps = np.stack(
        [np.sin(tilt), np.array([-0.7, -0.3, 0.0]) * sway / shares, np.cos(tilt)], axis=1
    )
    spine = np.concatenate([[[0.0, sway, 0.0]], steps * shares[:, None]]).cumsum(axis=0)
    turns = np.interp([0.0, 0.3, 0.66, 1.0], [0, 1], [posture.pelvis_turn, posture.chest_turn])
    facing = np.stack([np.cos(turns), np.sin(turns), np.zeros(4)], axis=1)
    return spine, facing


def _hanging(forward: Floats, outward: Floats) -> Floats:
    """Directions of bones that hang down, shape (2, 3)."""
    flat = np.cos(outward)
    return np.stack(
        [flat * np.sin(forward), SIDES * np.sin(outward), -flat * np.cos(forward)], axis=1
    )


def _arms(
    posture: Posture, size: Proportions, spine: Floats, facing: Floats
) -> tuple[Floats, np.ndarray]:
    turn = turn_z(posture.chest_turn)
    height = size.height
    places = np.stack(
        [np.full(2, -0.004), 0.092 * size.breadth * SIDES, np.full(2, -0.041)], axis=1
    )
    shoulders = spine[3] + height * places @ turn.T
    elbows = shoulders + size.upper_arm * _hanging(posture.arm, posture.arm_spread) @ turn.T
    fore = _hanging(posture.arm + posture.elbow, posture.arm_spread - 0.35 * posture.elbow)
    wrists = elbows + size.forearm * fore @ turn.T
    reaching = np.isfinite(posture.hands[:, 0])
    outward = np.stack([np.ones(2), SIDES, np.ones(2)], axis=1) * height
    for index in np.flatnonzero(reaching):
        wrists[index] = spine[3] + turn @ (posture.hands[index] * outward[index])
        raised = posture.hands[index, 2] > -0.05
        bend = turn @ np.array([0.1 if raised else -0.45, SIDES[index] * 0.6, -0.85])
        elbows[index] = reach(shoulders[index], wrists[index], size.upper_arm, size.forearm, bend)
    return np.stack([shoulders, elbows, wrists], axis=1), reaching


def _leg_give(legs: Floats, spine: Floats) -> Floats:
    """Loosened legs stride farther and stand slightly wider."""
    give = np.zeros_like(legs)
    give[..., 0] = (legs[..., 0] - spine[0, 0]) * np.array([1.0, 0.75, 1.0])
    give[..., 1] = (legs[..., 1] - spine[0, 1]) * np.array([0.0, 0.3, 0.6])
    return give


def _arm_give(arms: Floats, size: Proportions, reaching: np.ndarray) -> Floats:
    """Loosened arms swing farther and hang farther out; a hand that holds something stays."""
    give = np.zeros_like(arms)
    free = np.where(reaching, 0.0, 1.0)[:, None]
    give[..., 0] = (arms[..., 0] - arms[:, :1, 0]) * np.maximum(1.3 * free, 0.3)
    length = size.upper_arm + size.forearm
    out = np.array([0.0, 0.80, 1.0]) * free + np.array([0.0, 0.60, 0.05]) * (1.0 - free)
    give[..., 1] = SIDES[:, None] * out * length
    return give
