"""Upright bodies with rounded ends: lorry cabs, buses, trams, caravans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.material import Material
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.vehicles.hull import Outline, Skin, outline, skin
from avsec_gym.world.models.vehicles.paint import UNDERSIDE


@dataclass(frozen=True)
class BodyBand:
    """The surfaces between two heights, all round.

    Args:
        top: The upper edge, metres; the lower one is that of the band below.
        material: Material where there is no opening.
        front: Material of the front end, if it differs.
        rear: Material of the rear end, if it differs.
        openings: Rear edge, front edge, material of windows and doors on the sides.
        lean: Distance of its upper edge behind the front end's foremost line, metres.
        inset: Distance of its upper edge inside the widest line, metres.
    """

    top: float
    material: Material
    front: Material | None = None
    rear: Material | None = None
    openings: tuple[tuple[float, float, Material], ...] = ()
    lean: float = 0.0
    inset: float = 0.0


def coach(
    rear: float,
    front: float,
    half_width: float,
    bottom: float,
    bands: Sequence[BodyBand],
    *,
    axles: Sequence[float] = (),
    wheel: float = 0.45,
    rounding: tuple[float, float] = (0.2, 0.3),
    squareness: float = 4.5,
    rear_lean: float = 0.0,
) -> tuple[list[Mesh], Floats]:
    """A body of bands one above the other, with wheel arches and a roof.

    Args:
        rear: Coordinate x of its rear end, metres.
        front: Coordinate x of its front end, metres.
        half_width: Half of its width, metres.
        bottom: Height of its lower edge.
        bands: Bands from below; the last one's material is the roof's, too.
        axles: Coordinates x of the wheels that need an arch.
        wheel: Radius of the wheels, metres.
        rounding: Lengths over which the rear and the front narrow.
        squareness: Exponent of the plan's corners.
        rear_lean: Share of the bands' `lean` that holds at the rear, too.

    Returns:
        The surfaces, and the left side, shape (K, J, 3).
    """
    radius = wheel + 0.08
    arch = np.concatenate(
        [[-radius - 0.02], radius * np.sin(np.linspace(-1.57, 1.57, 7)), [radius + 0.02]]
    )
    edges = [edge for band in bands for opening in band.openings for edge in opening[:2]]
    stations = np.unique(
        np.round(
            np.concatenate(
                [*(axle + arch for axle in axles), edges, [rear + rounding[0], front - rounding[1]]]
            ),
            3,
        )
    )
    inside = (stations > rear + 0.06) & (stations < front - 0.06)
    plan = outline(rear, front, *rounding, stations[inside], squareness=squareness)
    low = np.full(len(plan.x), bottom)
    for axle in axles:
        room = radius**2 - (plan.x - axle) ** 2
        low = np.maximum(low, np.where(room > -1e-6, wheel + np.sqrt(np.maximum(room, 0)), 0.0))
    # A dark floor edge, a lip, the bands, and a row that rounds the roof's edge off.
    tops = np.array([band.top for band in bands])
    z = np.maximum(tops, low[:, None] + 0.03 + 0.02 * np.arange(len(bands)))
    z[:, -1] -= 0.08
    z = np.column_stack([low, low, z, z[:, -1] + 0.08])
    lean = np.array([0.3, 0.03, *(band.lean for band in bands), bands[-1].lean + 0.14])
    inset = np.array([0.35, 0.02, *(band.inset for band in bands), bands[-1].inset + 0.10])
    # The ends lean as a whole, and the sides follow over some distance.
    follow = min(1.9 * float(lean[1:].max()) + 0.2, 0.9 * (front - rear - sum(rounding)))
    to_front = np.clip((plan.x - (front - rounding[1] - follow)) / follow, 0.0, 1.0)
    to_rear = np.clip(((rear + rounding[0] + follow) - plan.x) / follow, 0.0, 1.0)
    x = plan.x[:, None] - to_front[:, None] * lean
    x += to_rear[:, None] * np.where(np.arange(len(lean)) < 1, lean, lean * rear_lean)
    y = (half_width - inset) * plan.y[:, None]
    body = skin(np.stack([x, y, z], axis=-1), (0.12, 0.38, 0.62, 0.88), 0.03)
    return _panels(plan, body, bands), body.left[:, 1:]


def _panels(plan: Outline, body: Skin, bands: Sequence[BodyBand]) -> list[Mesh]:
    every = slice(None)
    count = body.points.shape[1]
    floor = np.stack([body.points[:, -1], body.points[:, 0]], axis=1)
    down = np.zeros_like(floor)
    down[..., 2] = -1.0
    roof = slice(len(bands) + 1, count - len(bands) - 1)
    parts = [
        Skin(floor, down, 1).panel(UNDERSIDE, every, every),
        body.panel(UNDERSIDE, every, slice(0, 2)),
        body.panel(UNDERSIDE, every, slice(count - 2, count)),
        body.panel(bands[-1].material, every, roof),
    ]
    for number, band in enumerate(bands):
        low, high = number + 1, number + 2
        for columns, material in _columns(plan, band):
            right = body.panel(
                material, columns, slice(low, high + 1), _uv(body, columns, low, high, material, -1)
            )
            left = body.panel(
                material,
                columns,
                slice(count - 1 - high, count - low),
                _uv(body, columns, low, high, material, 1)[:, ::-1],
            )
            parts += [right, left]
    return parts


def _columns(plan: Outline, band: BodyBand) -> list[tuple[slice, Material]]:
    """Which columns of a band have which material, from the rear to the front."""
    last = len(plan.x) - 1
    rear_end = int(np.flatnonzero(plan.rear > 0.2)[-1])
    front_end = int(np.flatnonzero(plan.front > 0.2)[0])
    result = [] if band.rear is None else [(slice(0, rear_end + 1), band.rear)]
    at = 0 if band.rear is None else rear_end
    stop = last if band.front is None else front_end
    for first_x, second_x, material in band.openings:
        first, second = (int(np.abs(plan.x - x).argmin()) for x in (first_x, second_x))
        first, second = max(first, at), min(second, stop)
        if second <= first:
            continue
        if first > at:
            result.append((slice(at, first + 1), band.material))
        result.append((slice(first, second + 1), material))
        at = second
    if stop > at:
        result.append((slice(at, stop + 1), band.material))
    if band.front is not None:
        result.append((slice(front_end, last + 1), band.front))
    return result


def _uv(body: Skin, columns: slice, low: int, high: int, material: Material, side: int) -> Floats:
    """Windows show their texture once; other surfaces have it in metres, legible on both sides."""
    left = body.left[columns, low : high + 1]
    x, y, z = left[..., 0], left[..., 1], left[..., 2]
    bottom, top = z.min(axis=1, keepdims=True), z.max(axis=1, keepdims=True)
    if not material.glass:
        # Round the ends, too, the texture runs on along the outline.
        plan = body.left[:, 2, :2]
        arc = np.concatenate([[0.0], np.linalg.norm(np.diff(plan, axis=0), axis=1).cumsum()])
        along = (arc[-1] - arc if side > 0 else arc)[columns, None]
        return np.stack(np.broadcast_arrays(along, body.points[..., 2].max() - z), axis=-1)
    v = np.clip((top - z) / np.maximum(top - bottom, 1e-6), 0.01, 0.99)
    if np.ptp(y) > np.ptp(x):
        u = 0.5 + 0.49 * side * y / y.max()
    else:
        u = (x.max() - x) / max(float(np.ptp(x)), 1e-6)
    return np.stack([np.clip(u, 0.005, 0.995), v], axis=-1)
