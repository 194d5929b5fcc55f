"""The lower half of a car: flanks with wheel arches, bumpers, bonnet and boot lid in one skin."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.body_design import BodyDesign, CarDesign
from avsec_gym.world.models.vehicles.hull import Outline, Skin, outline, skin
from avsec_gym.world.models.vehicles.paint import LINING, PLASTIC, UNDERSIDE, Finish

ARCH_GAP = 0.05
"""Between tyre and wheel arch, metres."""

_LIP = 0.04
_FLARED = 0.13
"""Metres round a wheel arch over which its lip fades into the flank."""
_ACROSS = (0.07, 0.28, 0.5, 0.72, 0.93)
_ROWS = 11
"""Rows from the inside of the sill to the edge of bonnet and deck."""
_SHARES = np.array([0.0, 0.20, 0.42, 0.68, 1.0])
"""Heights of the five rows of the flank, from the lip to below the shoulder."""
_RAKED = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.06, 0.16, 0.28, 0.48, 0.70, 1.0])
"""Share of the rake by which each row lies behind the bumper."""
_CHIN = np.array([0.30, 0.30, 0.10, 0.035, 0.0, 0.004, 0.0, 0.0, 0.0, 0.0, 0.0])
_TAIL = np.array([0.30, 0.30, 0.10, 0.035, 0.0, 0.006, 0.02, 0.035, 0.05, 0.065, 0.10])
_STANDS_OUT = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.2, 0.9, 1.0, 1.0, 1.0, 1.0])
"""Share of the bumpers' depth by which each row lies behind them."""


def lower_skin(design: CarDesign) -> Skin:
    """The skin from lip to lip over the bonnet."""
    front = 0.5 * design.length
    radius = design.wheel + ARCH_GAP
    arch = radius * np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, 11))
    arch = np.concatenate(
        [[-radius - 0.09, -radius - 0.015], arch, [radius + 0.015, radius + 0.09]]
    )
    between = np.linspace(design.rear_axle + radius, design.front_axle - radius, 6)[1:-1]
    stations = np.concatenate([design.rear_axle + arch, between, design.front_axle + arch])
    body = design.body
    plan = outline(
        -front, front, 0.6 * body.roundness, body.roundness, stations, squareness=body.squareness
    )
    top = shoulder_height(design, plan.x)
    # The lip follows the arches; ahead of and behind the wheels it rises.
    beyond = (plan.x > design.front_axle) + 1.3 * (plan.x < design.rear_axle)
    bottom = np.maximum(
        design.sill + 0.045 * beyond,
        np.maximum(
            *(
                _arch_height(plan.x - axle, radius, design.wheel)
                for axle in (design.rear_axle, design.front_axle)
            )
        ),
    )
    start = design.sill + _LIP
    flank = start + _SHARES * (top[:, None] - 0.10 - start)
    flank = np.maximum(flank, bottom[:, None] + _LIP + 0.018 * np.arange(len(_SHARES)))
    inner = np.minimum(design.sill + 0.02, bottom)
    edge = np.stack([top - 0.05, top - 0.017, top], axis=1)
    edge[:, 0] = np.maximum(edge[:, 0], flank[:, -1] + 0.01)
    z = np.column_stack([inner, bottom, bottom, flank, edge])
    return skin(_bent(plan, design, z), _ACROSS, 0.06)


def shoulder_height(design: CarDesign, x: Floats) -> Floats:
    """Where the lower skin ends: bonnet, belt line and boot, at places along the car."""
    front = 0.5 * design.length
    # The bonnet falls slowly, then curls down to the nose: three quarters of a parabola.
    ahead = np.clip((x - design.bonnet) / (front - design.bonnet), 0.0, 1.0)
    bonnet = design.cowl - (design.cowl - design.nose) * (0.35 * ahead + 0.65 * ahead**3)
    belt = np.interp(
        x,
        [-front, design.boot, design.bonnet],
        [design.belt - 0.015, design.belt, design.cowl],
    )
    return np.where(x > design.bonnet, bonnet, belt)


def _bent(plan: Outline, design: CarDesign, z: Floats) -> Floats:
    """Left side of a lower skin, shape (K, J, 3): barrel-shaped in plan, its ends by row."""
    body = design.body
    middle = 0.5 * (plan.x[0] + plan.x[-1])
    barrel = 1.0 - 0.03 * ((plan.x - middle) / (plan.x[-1] - middle)) ** 2
    rake, bumper = body.rake * _RAKED, body.bumper * _STANDS_OUT
    upright = float(np.clip(body.tailgate / 0.3, 0.4, 1.0))
    x = plan.x[:, None] - plan.front[:, None] * (_CHIN + rake + bumper)
    x += plan.rear[:, None] * (upright * _TAIL + bumper)
    inset = np.broadcast_to(_inset(body), z.shape) - _flare(design, plan.x, z)
    y = (design.half_width * barrel[:, None] - inset) * plan.y[:, None]
    return np.stack([x, y, z], axis=-1)


def _inset(body: BodyDesign) -> Floats:
    """How far each row lies inside the widest line, metres, shape (J,)."""
    lean, hollow = body.tumble, body.crease
    return np.array(
        [0.27, 0.27, 0.055, 0.03, 0.010 + hollow, 0.004, 0.0, 0.25 * lean + hollow,
         0.6 * lean, lean + 0.012, lean + 0.075]
    )  # fmt: skip


def _flare(design: CarDesign, x: Floats, z: Floats) -> Floats:
    """How far the lips of the wheel arches stand out, shape (K, J)."""
    nearest = np.minimum(
        *(
            np.hypot(x[:, None] - axle, z - design.wheel)
            for axle in (design.rear_axle, design.front_axle)
        )
    )
    beyond = np.clip((nearest - design.wheel - ARCH_GAP) / _FLARED, 0.0, 1.0)
    lips = design.body.flare * (1.0 - beyond) ** 2
    lips[:, :2] = 0.0
    return np.asarray(lips)


def _arch_height(offset: Floats, radius: float, centre: float) -> Floats:
    inside = radius**2 - offset**2
    return np.where(inside > -1e-6, centre + np.sqrt(np.maximum(inside, 0.0)), 0.0)


def lower_panels(design: CarDesign, finish: Finish, lower: Skin) -> list[Mesh]:
    """The skin's surfaces: bumpers, flanks, bonnet, boot lid, the inside and the underside."""
    every = slice(None)
    count, middle = lower.points.shape[1], _ROWS + len(_ACROSS) // 2
    parts = [
        lower.panel(UNDERSIDE, every, slice(0, 3)),
        lower.panel(UNDERSIDE, every, slice(count - 3, count)),
    ]
    uv = _flank_uv(design, lower)
    radius = design.wheel + ARCH_GAP
    behind = int((lower.points[:, middle, 0] < design.rear_axle - radius).sum())
    ahead = int((lower.points[:, middle, 0] <= design.front_axle + radius).sum())
    for columns, material in (
        (slice(0, behind + 1), finish.bumper),
        (slice(behind, ahead), finish.flank),
        (slice(ahead - 1, None), finish.bumper),
    ):
        # Bumpers of black plastic reach up to the third row above the lip.
        whole = material is not PLASTIC
        for low, high in ((2, _ROWS),) if whole else ((2, 6), (5, _ROWS)):
            used = material if low == 2 and not whole else finish.flank
            for across in (slice(low, high), slice(count - high, count - low)):
                parts.append(lower.panel(used, columns, across, uv[columns, across]))
    # The floor closes the underside; under the greenhouse the deck is the dark inside of the car.
    floor = np.stack([lower.points[:, -1], lower.points[:, 0]], axis=1)
    down = np.zeros_like(floor)
    down[..., 2] = -1.0
    parts.append(Skin(floor, down, 1).panel(UNDERSIDE, every, every))
    along = lower.points[:, middle, 0]
    inside = np.flatnonzero((along > design.boot + 0.05) & (along < design.bonnet - 0.1))
    first, last = int(inside[0]), int(inside[-1])
    across = slice(_ROWS - 1, count - _ROWS + 1)
    lid = PLASTIC if design.body.kind == "pick-up" else finish.paint
    parts += [
        lower.panel(lid, slice(0, first + 1), across),
        lower.panel(LINING, slice(first, last + 1), across),
        lower.panel(finish.bonnet, slice(last, None), across, _bonnet_uv(lower, last, across)),
    ]
    return parts


def _flank_uv(design: CarDesign, lower: Skin) -> Floats:
    """Where the flank lies on its texture, on which axles and pillars have fixed places."""
    front = 0.5 * design.length
    side_rear = design.boot + 0.25
    side = design.bonnet - 0.3 - side_rear
    x = lower.points[..., 0]
    pillar = side_rear + side * design.body.windows[-1][0] - 0.04
    places = np.array([-front, design.rear_axle, pillar, design.front_axle - 0.42, front])
    u = np.interp(x, places, [0.0, 0.8, 2.1, 3.1, 4.0])
    top = shoulder_height(design, x)
    v = (top - lower.points[..., 2]) / np.maximum(top - design.sill, 0.1)
    return np.stack([u, np.clip(v, 0.01, 0.99)], axis=-1)


def _bonnet_uv(lower: Skin, first: int, across: slice) -> Floats:
    """Once over the bonnet, from side to side and from the windscreen to the front."""
    points = lower.points[first:, across]
    x, y = points[..., 0], points[..., 1]
    u = 0.5 + 0.49 * y / np.maximum(np.abs(y).max(axis=1, keepdims=True), 1e-6)
    v = (x.max() - x) / np.ptp(x)
    return np.stack([u, 0.99 - 0.98 * v], axis=-1)
