"""Backpacks and bags."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.models.people.body import trunk_at, trunk_sizes
from avsec_gym.world.models.people.clothing import Outfit
from avsec_gym.world.models.people.rings import Rings, rods, sweep
from avsec_gym.world.models.people.skeleton import SIDES, Skeleton


def luggage(skeleton: Skeleton, outfit: Outfit) -> list[Rings]:
    """What the person carries; empty for most people."""
    if outfit.luggage == "backpack":
        return _backpack(skeleton, outfit)
    if outfit.luggage == "shoulder bag":
        return _shoulder_bag(skeleton, outfit)
    if outfit.luggage in ("handbag", "shopping bag"):
        return _hand_bag(skeleton, outfit)
    return []


def _backpack(skeleton: Skeleton, outfit: Outfit) -> list[Rings]:
    height = skeleton.height
    straps = []
    centres, up, ahead = trunk_at(skeleton, np.array([0.06, 0.10, 0.22, 0.285]))
    back = trunk_sizes(skeleton, outfit, np.array([0.06, 0.10, 0.22, 0.285]))[:, 1]
    back += np.array([0.032, 0.042, 0.040, 0.020]) * height
    sizes = np.array(
        [(0.04, 0.045, 0.070), (0.05, 0.060, 0.088), (0.05, 0.055, 0.084), (0.03, 0.03, 0.058)]
    )
    sack = sweep(
        centres - back[:, None] * ahead, up, ahead, sizes * height, outfit.bag, squareness=0.5
    )
    level = np.array([0.314, 0.298, 0.250, 0.130])
    spine, _, ahead = trunk_at(skeleton, level)
    depth = np.array([-0.2, 0.85, 0.97, 0.30]) * trunk_sizes(skeleton, outfit, level)[:, 0]
    out = np.array([0.048, 0.052, 0.064, 0.092]) * skeleton.size.breadth * height
    for side in SIDES:
        line = spine + depth[:, None] * ahead + side * out[:, None] * _aside(ahead)
        straps.append(_strap(line, outfit, 0.011 * height))
    return [sack, *straps]


def _shoulder_bag(skeleton: Skeleton, outfit: Outfit) -> list[Rings]:
    """At the hip, its strap over the other shoulder."""
    height, side = skeleton.height, SIDES[outfit.side]
    level = np.array([0.01, 0.13, 0.25, 0.314])
    spine, _, ahead = trunk_at(skeleton, level)
    sizes, aside = trunk_sizes(skeleton, outfit, level), _aside(ahead)
    hip = spine[0] + side * (sizes[0, 2] + 0.028 * height) * aside[0]
    hip -= 0.03 * height * ahead[0]
    levels = np.array([-0.075, -0.06, 0.05, 0.062])[:, None] * [0.0, 0.0, height]
    sack = np.array(
        [(0.075, 0.075, 0.018), (0.088, 0.088, 0.030), (0.088, 0.088, 0.024), (0.08, 0.08, 0.014)]
    )
    bag = sweep(hip + levels, (0, 0, 1), ahead[0], sack * height, outfit.bag, squareness=0.6)
    over = spine[3] - side * 0.050 * height * aside[3]
    line = []
    for face, depth in ((0, 1.03), (1, -1.03)):
        across = side * height * np.array([[0.050], [-0.025]])
        chest = spine[1:3] + depth * sizes[1:3, face, None] * ahead[1:3] + across * aside[1:3]
        tip = hip + [0.0, 0.0, 0.05 * height] + 0.6 * depth * sizes[0, face] * ahead[0]
        line += [tip, *chest, over] if face == 0 else [*chest[::-1], tip]
    return [bag, _strap(np.array(line), outfit, 0.009 * height)]


def _hand_bag(skeleton: Skeleton, outfit: Outfit) -> list[Rings]:
    """Hanging from a hand."""
    height = skeleton.height
    elbow, wrist = skeleton.arms[outfit.side, 1:]
    grip = wrist + 0.065 * height * (wrist - elbow) / np.linalg.norm(wrist - elbow)
    large = 1.15 if outfit.luggage == "shopping bag" else 1.0
    levels = np.array([-0.23, -0.215, -0.10, -0.09])[:, None] * [0.0, 0.0, large * height]
    levels[:, 2] += 0.03 * (large - 1.0) * height
    sizes = np.array(
        [(0.07, 0.07, 0.028), (0.085, 0.085, 0.036), (0.072, 0.072, 0.024), (0.06, 0.06, 0.01)]
    )
    give = skeleton.arm_give[outfit.side, 2]
    bag = sweep(
        grip + levels,
        (0, 0, 1),
        skeleton.facing[0],
        sizes * large * height,
        outfit.bag,
        give=give,
        squareness=0.6,
    )
    top = grip + levels[3]
    ends = np.stack([top + skeleton.facing[0] * reach * height for reach in (0.045, -0.045)])
    handle = rods(
        np.stack([grip, grip]), ends, 0.005 * height, outfit.bag, sides=4, give=(give, give)
    )
    return [bag, handle]


def _strap(line: Floats, outfit: Outfit, radius: float) -> Rings:
    return rods(line[:-1], line[1:], radius, outfit.bag, sides=3)


def _aside(ahead: Floats) -> Floats:
    """To the left of directions, shape (n, 3)."""
    return np.stack([-ahead[:, 1], ahead[:, 0], 0.0 * ahead[:, 0]], axis=1)
