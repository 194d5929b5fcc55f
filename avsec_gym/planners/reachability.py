"""Where a vehicle can be, steps from now, on an empty plane: bounds that make the search lean.

For every class of primitives that may follow a node and every number of time steps j, the table
holds a box around all places that the vehicle's centre can have after exactly j steps, in the
node's frame, and the interval of its heading changes.  The bounds may be too wide, never too
narrow; a search that drops a node whose bounds miss the goal loses no solution.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel
from avsec_gym.planners.primitives import MotionPrimitives, PrimitiveArrays

_BINS = 128
"""Headings between -2 pi and 2 pi, kept apart so that boxes need not be rotated."""
_LARGEST_WORK = 20_000_000
"""Rough number of updates (a fifth of a second) beyond which the table is not worth making."""


@lru_cache(maxsize=64)
def reach_table(primitives: MotionPrimitives, horizon: int) -> Floats:
    """The bounds for every class.

    Args:
        primitives: The set.
        horizon: Largest number of steps.

    Returns:
        x_min, x_max, y_min, y_max (m, of the centre, relative to the rear axle's pose), lowest and
        highest heading change (rad), shape (classes, horizon + 1, 6); boxes that nothing reaches
        have x_min > x_max.  Without rows where the set is too large for it to pay.
    """
    if primitives.grid is not None:  # What leads onto a grid follows nothing: no class has it.
        return reach_table(primitives.grid, horizon)
    arrays = primitives.arrays
    classes = int(arrays.end_class.max()) + 1
    # Not every heading is reached in every step, nor does every class follow every other.
    work = classes * horizon * _BINS * len(arrays.successors) / 16
    if work > _LARGEST_WORK:
        return np.zeros((0, horizon + 1, 6))
    return np.asarray(_bounds(arrays, classes, horizon, primitives.vehicle.rear_axle))


@kernel(nogil=True)
def _bounds(
    primitives: PrimitiveArrays, classes: int, horizon: int, centre_offset: float
) -> Floats:
    """The table of `reach_table`.

    Invariant: boxes[s, k, b] holds every rear-axle pose that a sequence of primitives reaches after
    s steps with an end of class k and a heading of bin b; empty boxes begin with infinity.  Steps
    are visited in order, and primitives lead to later ones, so that a box is complete when it is
    driven on from.
    """
    table = np.empty((classes, horizon + 1, 6))
    table[..., 0], table[..., 2], table[..., 4] = np.inf, np.inf, np.inf
    table[..., 1], table[..., 3], table[..., 5] = -np.inf, -np.inf, -np.inf
    # All primitives of a class have the same successors: one stands for it.
    example = np.zeros(classes, np.int64)
    for p in range(primitives.steps.shape[0]):
        example[primitives.end_class[p]] = p
    for start in range(classes):
        boxes = np.empty((horizon + 1, classes, _BINS, 6))
        boxes[..., 0] = np.inf
        _widen(boxes[0, start, _BINS // 2], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        for s in range(horizon):
            for k in range(classes):
                first = primitives.first_successor[example[k]]
                last = primitives.first_successor[example[k] + 1]
                for b in range(_BINS):
                    if boxes[s, k, b, 0] != np.inf:
                        for i in range(first, last):
                            p = primitives.successors[i]
                            _advance(
                                boxes, s, k, b, p, primitives, table[start], horizon, centre_offset
                            )
    return table


@kernel(nogil=True)
def _advance(
    boxes: Floats,
    s: int,
    k: int,
    b: int,
    p: int,
    primitives: PrimitiveArrays,
    table: Floats,
    horizon: int,
    centre_offset: float,
) -> None:
    """Drive primitive p from everywhere in one box.

    Invariant: boxes only widen, so that no pose is lost; they may hold poses that none reaches.
    """
    x1, x2, y1, y2 = boxes[s, k, b, 0], boxes[s, k, b, 1], boxes[s, k, b, 2], boxes[s, k, b, 3]
    low, high = boxes[s, k, b, 4], boxes[s, k, b, 5]
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    cos, sin = np.cos(middle), np.sin(middle)
    count = primitives.steps[p]
    for j in range(1, count + 1):
        if s + j > horizon:
            return
        px, py = primitives.states[p, j, 0], primitives.states[p, j, 1]
        turn = primitives.states[p, j, 3]
        qx, qy = px + centre_offset * np.cos(turn), py + centre_offset * np.sin(turn)
        # A vector turned by up to `half` more or less ends within its length times `half`.
        slack = half * np.sqrt(qx * qx + qy * qy)
        dx, dy = cos * qx - sin * qy, sin * qx + cos * qy
        _widen(
            table[s + j],
            x1 + dx - slack,
            x2 + dx + slack,
            y1 + dy - slack,
            y2 + dy + slack,
            low + turn,
            high + turn,
        )
        # At its end the primitive leads into a box from which others follow.
        if j == count:
            slack = half * np.sqrt(px * px + py * py)
            dx, dy = cos * px - sin * py, sin * px + cos * py
            place = int((middle + turn + 2 * np.pi) / (4 * np.pi) * _BINS + 0.5)
            place = min(max(place, 0), _BINS - 1)
            _widen(
                boxes[s + j, primitives.end_class[p], place],
                x1 + dx - slack,
                x2 + dx + slack,
                y1 + dy - slack,
                y2 + dy + slack,
                low + turn,
                high + turn,
            )


@kernel(nogil=True)
def _widen(
    box: Floats, x1: float, x2: float, y1: float, y2: float, low: float, high: float
) -> None:
    """Widen a box, which may be empty, so that it holds another."""
    if box[0] == np.inf:
        box[0], box[1], box[2], box[3], box[4], box[5] = x1, x2, y1, y2, low, high
        return
    box[0], box[1] = min(box[0], x1), max(box[1], x2)
    box[2], box[3] = min(box[2], y1), max(box[3], y2)
    box[4], box[5] = min(box[4], low), max(box[5], high)
