"""The upper half of a car: windows between pillars, and the roof."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.body_design import CarDesign
from avsec_gym.world.models.vehicles.hull import Outline, Skin, outline, skin
from avsec_gym.world.models.vehicles.lower_body import shoulder_height
from avsec_gym.world.models.vehicles.paint import BLACK_GLOSS, CLOTH, Finish

_REAR_ROUND, _FRONT_ROUND = 0.24, 0.34
_ACROSS = (0.10, 0.30, 0.5, 0.70, 0.90)
_TRIM = 0.05
"""Upper edge of the strip under the windows, share of the way from the belt to the roof."""


def greenhouse_skin(design: CarDesign) -> tuple[Outline, Skin]:
    """The plan at the belt, and the skin from belt to belt over the roof."""
    body = design.body
    side = np.array([design.boot + _REAR_ROUND, design.bonnet - _FRONT_ROUND])
    edges = np.array(sorted({edge for window in body.windows for edge in window}))
    # Columns at the windows' edges, and one in the middle of long windows and pillars.
    halves = 0.5 * (edges[1:] + edges[:-1])[np.diff(edges) > 0.2]
    stations = side[0] + np.sort(np.concatenate([edges, halves])) * (side[1] - side[0])
    plan = outline(
        design.boot,
        design.bonnet,
        _REAR_ROUND,
        _FRONT_ROUND,
        stations,
        squareness=max(2.6, body.squareness - 0.2),
    )
    # Every column leans by its place: forward ones with the windscreen, others with the rear.
    pillar = side[0] + (side[1] - side[0]) * 0.5
    forward = np.clip((plan.x - pillar) / (side[1] - pillar), 0.0, 1.0)
    backward = np.clip((pillar - plan.x) / (pillar - side[0]), 0.0, 1.0)
    glass = body.glass
    rows = [0.0, _TRIM, 0.5 * glass + 0.05, glass, 0.955, 0.99, 1.0]
    level = np.tile(rows, (len(plan.x), 1))
    level[plan.rear > 0, 1], level[plan.rear > 0, 3] = body.rear_glass
    bulge = 0.05 * np.sin(np.pi * level)
    shift = forward[:, None] * ((design.roof_front - design.bonnet) * level + bulge)
    shift += backward[:, None] * ((design.roof_rear - design.boot) * level - bulge)
    x = plan.x[:, None] + shift
    shoulder = design.half_width - body.tumble - 0.045
    roof = design.half_width * body.roof
    width = shoulder + (roof - shoulder) * level**1.2 + 0.3 * bulge
    # The last rows round the roof's edge off.
    width[:, -2:] -= (0.018, 0.065)
    y = width * plan.y[:, None]
    base = shoulder_height(design, plan.x) - 0.012
    middle = 0.5 * (design.roof_front + design.roof_rear)
    place = (x[:, -1] - middle) / (0.5 * (design.roof_front - design.roof_rear))
    edge = design.height - 0.045 - 0.05 * place**2
    edge -= body.roof_drop * np.clip(-place, 0.0, 1.0) ** 2
    z = base[:, None] + level * (edge - base)[:, None]
    z[:, -3:-1] -= (0.006, 0.014)
    left = np.stack([x, y, z], axis=-1)
    left[:, -1, 0] += 0.05 * (backward * (plan.rear > 0) - forward * (plan.front > 0))
    return plan, skin(left, _ACROSS, 0.05)


def greenhouse_panels(design: CarDesign, finish: Finish, plan: Outline, upper: Skin) -> list[Mesh]:
    """Roof, pillars, windows, and the strip under the windows."""
    every = slice(None)
    count, last = upper.points.shape[1], len(plan.x) - 1
    roof = CLOTH if design.body.kind == "roadster" else finish.paint
    parts = [upper.panel(roof, every, slice(3, count - 3))]
    rear_edge = int(np.flatnonzero(plan.rear > 0.3)[-1])
    front_edge = int(np.flatnonzero(plan.front > 0)[0])
    bands: list[tuple[int, int, Material]] = [(0, rear_edge, finish.rear_glass)]
    at = rear_edge
    for number, (first, second) in enumerate(_window_columns(design, plan)):
        if first > at:
            bands.append((at, first, roof if at == rear_edge else BLACK_GLOSS))
        front_seats = number == len(design.body.windows) - 1
        bands.append((first, second, finish.side_glass if front_seats else finish.back_glass))
        at = second
    bands += [(at, front_edge, finish.paint), (front_edge, last, finish.windscreen)]
    for first, second, material in bands:
        columns = slice(first, second + 1)
        for across in (slice(1, 4), slice(count - 4, count - 1)):
            uv = _glass_uv(upper, columns, across, material)
            parts.append(upper.panel(material, columns, across, uv))
        below = finish.trim if material.clear and material.texture.startswith("side") else roof
        if material is finish.windscreen:
            below = BLACK_GLOSS
        for across in (slice(0, 2), slice(count - 2, count)):
            parts.append(upper.panel(below, columns, across))
    return parts


def _window_columns(design: CarDesign, plan: Outline) -> list[tuple[int, int]]:
    start, end = design.boot + _REAR_ROUND, design.bonnet - _FRONT_ROUND
    at = [[start + share * (end - start) for share in window] for window in design.body.windows]
    return [
        (int(np.abs(plan.x - rear).argmin()), int(np.abs(plan.x - front).argmin()))
        for rear, front in at
    ]


def _glass_uv(upper: Skin, columns: slice, across: slice, material: Material) -> Floats:
    """Once over each window; over the whole width for the windscreen and the rear window."""
    points = upper.points[columns, across]
    z = points[..., 2]
    low, high = z.min(axis=1, keepdims=True), z.max(axis=1, keepdims=True)
    v = (high - z) / np.maximum(high - low, 1e-6)
    if material.texture.startswith("side"):
        x = points[..., 0]
        u = (x.max() - x) / max(float(np.ptp(x)), 1e-6)
    else:
        way = 1.0 if material.texture.startswith("wind") else -1.0
        u = 0.5 + way * 0.5 * points[..., 1] / np.abs(points[..., 1]).max()
    return np.stack([np.clip(u, 0.005, 0.995), np.clip(v, 0.01, 0.99)], axis=-1)
