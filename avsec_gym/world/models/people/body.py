"""Clothed bodies: rings round the bones of a skeleton."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.models.people.clothing import Outfit
from avsec_gym.world.models.people.head import head
from avsec_gym.world.models.people.rings import Rings, interpolated, sweep, unit
from avsec_gym.world.models.people.skeleton import Proportions, Skeleton, turn_y, turn_z

# All sizes are in body heights: half sizes to the front, to the back and to the side.
# The trunk by its level above the hip joints.
_TRUNK = np.array(
    [
        (-0.040, 0.064, 0.074, 0.096),
        (0.000, 0.066, 0.074, 0.099),
        (0.045, 0.064, 0.062, 0.094),
        (0.095, 0.060, 0.054, 0.085),
        (0.180, 0.067, 0.062, 0.096),
        (0.240, 0.064, 0.068, 0.107),
        (0.276, 0.051, 0.064, 0.108),
        (0.299, 0.037, 0.053, 0.086),
        (0.322, 0.031, 0.039, 0.039),
    ]
)
# Limbs by station: 0 at shoulder or hip, 1 at elbow or knee, 2 at wrist or ankle.
_ARM = np.array(
    [
        (-0.09, 0.022, 0.022, 0.019),
        (0.10, 0.034, 0.035, 0.031),
        (0.35, 0.031, 0.031, 0.029),
        (0.80, 0.027, 0.028, 0.026),
        (1.15, 0.026, 0.028, 0.025),
        (1.60, 0.021, 0.022, 0.020),
        (2.00, 0.017, 0.017, 0.015),
    ]
)
_LEG = np.array(
    [
        (0.02, 0.046, 0.056, 0.048),
        (0.40, 0.045, 0.048, 0.044),
        (0.88, 0.035, 0.034, 0.033),
        (1.10, 0.031, 0.034, 0.030),
        (1.42, 0.027, 0.039, 0.030),
        (1.75, 0.021, 0.027, 0.022),
        (2.00, 0.019, 0.023, 0.018),
    ]
)
_TROUSERS = np.array(
    [
        (0.02, 0.048, 0.058, 0.050),
        (0.40, 0.047, 0.050, 0.046),
        (0.88, 0.037, 0.037, 0.036),
        (1.10, 0.035, 0.037, 0.034),
        (1.42, 0.031, 0.040, 0.034),
        (1.75, 0.029, 0.037, 0.032),
        (2.00, 0.032, 0.037, 0.032),
    ]
)
# The shoe by its place along the foot (0 below the ankle, in foot lengths): height above the sole
# and half width, in body heights.
_SHOE = np.array(
    [
        (-0.27, 0.030, 0.013),
        (-0.18, 0.047, 0.021),
        (0.18, 0.040, 0.023),
        (0.47, 0.027, 0.028),
        (0.73, 0.014, 0.015),
    ]
)
_HAND = np.array(
    [
        (0.000, 0.016, 0.012),
        (0.028, 0.023, 0.013),
        (0.058, 0.022, 0.013),
        (0.088, 0.016, 0.010),
    ]
)


def body(skeleton: Skeleton, outfit: Outfit) -> list[Rings]:
    """Everything from the shoes to the hat, without luggage."""
    below = _seat if outfit.skirt is None else _skirt
    parts = [_trunk(skeleton, outfit), below(skeleton, outfit), *head(skeleton, outfit)]
    for side in range(2):
        parts += [
            _leg(skeleton, outfit, side),
            _shoe(skeleton, outfit, side),
            _arm(skeleton, outfit, side),
            _hand(skeleton, outfit, side),
        ]
    return parts


def trunk_at(skeleton: Skeleton, level: Floats) -> tuple[Floats, Floats, Floats]:
    """Centres, upward and forward directions of the trunk.

    Args:
        skeleton: The skeleton of the person.
        level: Heights above the hip joints along the spine, in body heights, shape (n,).
    """
    place = np.asarray(level, float) * skeleton.height
    way = skeleton.size.trunk * np.array([0.0, 0.30, 0.66, 1.0])
    step = skeleton.spine[[1, 2, 3, 3]] - skeleton.spine[[0, 0, 1, 2]]
    table = np.concatenate([skeleton.spine, unit(step), skeleton.facing], axis=1)
    rows = interpolated(place, way, table)
    centres, up, ahead = rows[:, :3], rows[:, 3:6], rows[:, 6:]
    beyond = np.minimum(place, 0.0) + np.maximum(place - way[-1], 0.0)
    return centres + beyond[:, None] * up, up, ahead


def trunk_sizes(skeleton: Skeleton, outfit: Outfit, level: Floats) -> Floats:
    """Half sizes of the clothed trunk to the front, to the back and to the side, shape (n, 3)."""
    sizes = interpolated(level, _TRUNK[:, 0], _TRUNK[:, 1:])
    thick = outfit.bulk * np.interp(level, [-0.04, 0.2, 0.32], [1.3, 1.0, 0.25])
    figure = _figure(level, outfit, skeleton.size.breadth)
    return np.asarray((sizes * figure + thick[:, None]) * skeleton.height)


def _trunk(skeleton: Skeleton, outfit: Outfit) -> Rings:
    low = max(outfit.hem, -0.04)
    level = np.append(low, _TRUNK[_TRUNK[:, 0] > low + 0.01, 0])
    sizes = trunk_sizes(skeleton, outfit, level)
    centres, up, ahead = trunk_at(skeleton, level)
    if outfit.hem < -0.05:
        hang = _around_legs(
            skeleton, np.array([outfit.hem, 0.5 * (outfit.hem - 0.04)]), outfit.bulk
        )
        centres, sizes = np.concatenate([hang[0], centres]), np.concatenate([hang[1], sizes])
        up = np.concatenate([np.tile([0.0, 0.0, 1.0], (2, 1)), up])
        ahead = np.concatenate([ahead[:1], ahead[:1], ahead])
    swell = np.where(np.arange(len(centres)) < len(centres) - len(level), 0.8, 0.0)
    codes = np.zeros((len(centres), 12), np.int32)
    if outfit.is_open:
        codes[:, [0, 11]] = 1
    materials = (outfit.top, outfit.inner)
    return sweep(
        centres, up, ahead, sizes, materials, sides=12, codes=codes, squareness=0.12, swell=swell
    )


def _figure(level: Floats, outfit: Outfit, breadth: float) -> Floats:
    """Factors of the trunk's half sizes, shape (n, 3)."""
    belly = np.interp(level, [-0.04, 0.08, 0.2, 0.28], [0.8, 1.0, 0.6, 0.1])
    factors = 1.0 + outfit.stout * belly[:, None] * np.array([1.8, 0.7, 1.0])
    factors[:, 2] *= breadth
    if outfit.feminine:
        points = [-0.04, 0.02, 0.095, 0.2, 0.25, 0.32]
        factors[:, 2] *= np.interp(level, points, [1.03, 1.03, 0.86, 0.90, 0.92, 0.92])
        factors[:, 0] *= np.interp(level, points, [0.95, 0.95, 0.92, 1.25, 1.05, 0.9])
    return factors


def _seat(skeleton: Skeleton, outfit: Outfit) -> Rings:
    """Trousers from the waist to the crotch."""
    level = np.array([-0.065, -0.03, 0.06])
    table = np.array([(0.030, 0.044, 0.050), (0.058, 0.071, 0.093), (0.058, 0.058, 0.088)])
    centres, up, ahead = trunk_at(skeleton, level)
    sizes = table * _figure(level, outfit, skeleton.size.breadth) * skeleton.height
    return sweep(centres, up, ahead, sizes, outfit.legs, squareness=0.12)


def _skirt(skeleton: Skeleton, outfit: Outfit) -> Rings:
    edge = outfit.skirt or 0.0
    level = np.array([edge, 0.5 * edge - 0.02])
    centres, sizes = _around_legs(skeleton, level, 0.004 - 0.04 * edge)
    top, up, ahead = trunk_at(skeleton, np.array([0.0, 0.09]))
    waist = np.array([(0.068, 0.076, 0.1), (0.060, 0.055, 0.078)]) * skeleton.height
    waist[:, 2] *= skeleton.size.breadth
    return sweep(
        np.concatenate([centres, top]),
        np.concatenate([np.tile([0.0, 0.0, 1.0], (2, 1)), up]),
        np.concatenate([ahead[:1].repeat(2, 0), ahead]),
        np.concatenate([sizes, waist]),
        outfit.lower,
        sides=12,
        squareness=0.3,
        swell=[1.0, 0.9, 0.0, 0.0],
    )


def _around_legs(skeleton: Skeleton, level: Floats, room: float) -> tuple[Floats, Floats]:
    """Centres and half sizes of rings that hang around both legs."""
    height = skeleton.height
    z = skeleton.spine[0, 2] + level * height
    legs = skeleton.legs[:, ::-1]
    x = np.stack([np.interp(z, leg[:, 2], leg[:, 0]) for leg in legs])
    y = np.stack([np.interp(z, leg[:, 2], leg[:, 1]) for leg in legs])
    thick = (np.interp(level, [-0.4, -0.2, -0.05], [0.036, 0.046, 0.056]) + room) * height
    centres = np.stack([x.mean(axis=0), y.mean(axis=0), z], axis=1)
    reach = 0.5 * 1.3 * np.ptp(x, axis=0) + thick
    aside = 0.5 * np.ptp(y, axis=0) + thick
    return centres, np.stack([reach, reach, aside], axis=1)


def _limb(joints: Floats, give: Floats, station: Floats) -> tuple[Floats, Floats, Floats]:
    """Places, directions and give along a limb of two bones."""
    bones = np.diff(joints, axis=0)
    share = np.clip((station - 0.82) / 0.36, 0.0, 1.0)[:, None]
    share = share * share * (3.0 - 2.0 * share)
    lower = station[:, None] > 1.0
    places = np.where(
        lower,
        joints[1] + (station[:, None] - 1.0) * bones[1],
        joints[0] + station[:, None] * bones[0],
    )
    direction = unit(unit(bones[0]) * (1.0 - share) + unit(bones[1]) * share)
    return places, direction, interpolated(station, np.arange(3.0), give)


def _two_layers(inner: Floats, outer: Floats, end: float) -> tuple[Floats, np.ndarray]:
    """A table of sizes, clothed up to a station and bare beyond, and which band is bare."""
    stations = inner[:, 0]

    def at(table: Floats, station: float) -> list[float]:
        return [station, *(np.interp(station, stations, line) for line in table.T[1:])]

    if end >= 1.9:
        rows = outer.copy()
        rows[-1, 0] = end
        return rows, np.zeros((len(rows), 1), np.int32)
    kept = outer[stations < end - 0.08]
    left = inner[stations > end + 0.08]
    rows = np.concatenate([kept, [at(outer, end), at(inner, end - 0.02)], left])
    return rows, (np.arange(len(rows)) > len(kept))[:, None].astype(np.int32)


def _leg(skeleton: Skeleton, outfit: Outfit, side: int) -> Rings:
    wide = _TROUSERS * np.array([1.0, outfit.loose, outfit.loose, outfit.loose])
    table, codes = _two_layers(_LEG, wide, outfit.trouser_end)
    if outfit.stout:
        table[:, 1:] *= 1.0 + 0.5 * outfit.stout * np.clip(1.2 - table[:, :1], 0, 1)
    places, direction, give = _limb(skeleton.legs[side], skeleton.leg_give[side], table[:, 0])
    turn = skeleton.foot_turn[side]
    front = np.array([np.cos(turn), np.sin(turn), 0.35])
    sizes = table[:, 1:] * skeleton.height
    return sweep(
        places,
        direction,
        front,
        sizes,
        (outfit.legs, outfit.skin),
        codes=codes,
        give=give,
        capped=False,
    )


def _arm(skeleton: Skeleton, outfit: Outfit, side: int) -> Rings:
    slim = 0.86 if outfit.feminine else 1.0
    bare = _ARM * np.array([1.0, slim, slim, slim])
    thick = outfit.bulk * np.interp(_ARM[:, 0], [0.0, 1.0, 2.0], [0.35, 0.5, 0.7])[:, None]
    worn = np.concatenate([bare[:, :1], bare[:, 1:] * 1.06 + thick], axis=1)
    table, codes = _two_layers(bare, worn, outfit.sleeve)
    places, direction, give = _limb(skeleton.arms[side], skeleton.arm_give[side], table[:, 0])
    front = skeleton.facing[3] + np.array([0.0, 0.0, 0.5])
    sizes = table[:, 1:] * skeleton.height
    return sweep(places, direction, front, sizes, (outfit.top, outfit.skin), codes=codes, give=give)


def _hand(skeleton: Skeleton, outfit: Outfit, side: int) -> Rings:
    _, elbow, wrist = skeleton.arms[side]
    direction = unit(wrist - elbow)
    curl = unit(direction + 0.25 * skeleton.facing[3])
    along = _HAND[:, :1] * skeleton.height
    places = wrist + np.where(along > 0.03 * skeleton.height, along * curl, along * direction)
    sizes = _HAND[:, [1, 1, 2]] * skeleton.height
    front = skeleton.facing[3] + np.array([0.0, 0.0, 0.5])
    return sweep(
        places, direction, front, sizes, outfit.skin, sides=6, give=skeleton.arm_give[side, 2]
    )


def _shoe(skeleton: Skeleton, outfit: Outfit, side: int) -> Rings:
    size = Proportions(skeleton.height)
    place, tall, wide = _SHOE.T * np.array([[size.foot], [skeleton.height], [skeleton.height]])
    pitch = float(skeleton.foot_pitch[side])
    ball = 0.46 * size.foot
    bend = float(np.clip(-0.75 * pitch, 0.0, 0.7))
    beyond = np.maximum(place - ball, 0.0)
    x = np.minimum(place, ball) + np.cos(bend) * beyond
    z = 0.5 * tall - size.ankle + np.sin(bend) * beyond
    direction = np.where((place > ball)[:, None], [np.cos(bend), 0, np.sin(bend)], [1.0, 0, 0])
    codes = np.zeros((len(place), 8), np.int32)
    codes[:, 2:6] = 1
    rings = sweep(
        np.stack([x, np.zeros_like(x), z], axis=1),
        direction,
        (0.0, 0.0, 1.0),
        np.stack([0.5 * tall, 0.5 * tall, wide], axis=1),
        (outfit.shoes, outfit.soles),
        codes=codes,
        squareness=0.7,
    )
    turn = turn_z(float(skeleton.foot_turn[side])) @ turn_y(-pitch)
    ankle = skeleton.legs[side, 2]
    return rings.carried(turn, ankle, skeleton.leg_give[side, 2])
