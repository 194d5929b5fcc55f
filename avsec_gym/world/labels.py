"""KITTI's labels of a rendered frame: boxes, truncation, occlusion, and regions not to care about.

Occlusion comes from the picture itself: the share of an object's silhouette that is seen.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.geometry import Floats, transform_points, wrap_angle
from avsec_gym.rig import SensorRig
from avsec_gym.world.actors import Actors
from avsec_gym.world.rendering.renderer import Geometry
from avsec_gym.world.rendering.silhouettes import Silhouettes

FULLY_VISIBLE, PARTLY_VISIBLE, BARELY_VISIBLE = 0.97, 0.60, 0.08
"""Seen shares of the silhouette above which the occlusion is 0, 1, 2; below it is unknown, 3.

The first two are where KITTI's annotators change their minds, as twins of their frames show
(`avsec_gym.experiments.world_occlusion`)."""
SMALLEST_HEIGHT = 10.0
"""Pixels; objects that look smaller are not labelled but belong to a DontCare region."""
_UNKNOWN = 3
_UNDECIDED_AT_BORDER, _UNDECIDED = 0.25, 0.14
"""Shares of objects with unknown occlusion in KITTI: cut by the border; other large vehicles."""
FEWEST_PIXELS = 12
"""Fewest pixels that are seen of a labelled object."""
FARTHEST = 90.0
"""Metres ahead; KITTI labels little beyond 80 m."""


class FrameLabels(NamedTuple):
    """The contents of a label file, and the actor of each line."""

    boxes: Boxes3D
    """Boxes with 2D boxes, truncation, occlusion, alpha and moving flags, from near to far."""
    actor: NDArray[np.int64]
    """Index of each box's actor, shape (N,)."""
    dont_care: Floats
    """2D boxes of regions with objects too small or too hidden to be labelled, shape (M, 4)."""


def label_frame(
    actors: Actors,
    rig: SensorRig,
    vehicle_to_world: Floats,
    geometry: Geometry,
    alone: Silhouettes,
    own: int | None = None,
) -> FrameLabels:
    """Label what the reference camera sees.

    Args:
        actors: Actors in the world frame; actor i has the object id i.
        rig: The sensors of the vehicle that looks.
        vehicle_to_world: Pose of that vehicle, shape (4, 4).
        geometry: View of the reference camera.
        alone: View of the reference camera of each actor alone.
        own: Index of the vehicle that carries the rig: it has no label.
    """
    location, rotation_y = boxes_in_camera(actors, rig, vehicle_to_world)
    height, width = geometry.object_id.shape
    limit = np.array([width - 1.0, height - 1.0, width - 1.0, height - 1.0])
    extent = np.nan_to_num(alone.extent, nan=-1e6)
    box2d = np.clip(extent, 0.0, limit)
    full = np.prod(np.maximum(extent[:, 2:] - extent[:, :2], 1e-9), axis=1)
    inside = np.prod(box2d[:, 2:] - box2d[:, :2], axis=1)
    truncation = np.clip(1.0 - inside / full, 0.0, 1.0)
    ids = geometry.object_id[geometry.object_id >= 0]
    seen = np.bincount(ids, minlength=len(actors))
    share = seen / np.maximum(alone.area, 1)

    there = (seen > 0) & (np.arange(len(actors)) != (-1 if own is None else own))
    ahead = (location[:, 2] > 0.5) & (location[:, 2] < FARTHEST)
    tall = box2d[:, 3] - box2d[:, 1] >= SMALLEST_HEIGHT
    labelled = there & ahead & tall & (seen >= FEWEST_PIXELS) & (share > 0.02)
    order = np.flatnonzero(labelled)
    order = order[np.argsort(np.hypot(location[order, 0], location[order, 2]), kind="stable")]
    levels = np.searchsorted([-FULLY_VISIBLE, -PARTLY_VISIBLE, -BARELY_VISIBLE], -share)
    levels[_undecided(actors, truncation)] = _UNKNOWN
    boxes = Boxes3D(
        location=location[order],
        dimensions=actors.dimensions[order],
        rotation_y=rotation_y[order],
        score=np.ones(len(order)),
        category=actors.category[order],
        box2d=box2d[order],
        truncation=truncation[order],
        occlusion=levels[order].astype(float),
        alpha=wrap_angle(rotation_y - np.arctan2(location[:, 0], location[:, 2]))[order],
        moving=actors.moving[order],
    )
    return FrameLabels(boxes, order, _united(box2d[there & ~labelled]))


def _undecided(actors: Actors, truncation: Floats) -> NDArray[np.bool_]:
    """Objects whose occlusion is labelled as unknown whatever is seen of them, shape (N,).

    KITTI's annotators left it open for a quarter of what the image's border cuts, and for an
    eighth of all vans and lorries.  Their choice is drawn from an actor's looks, so it stays.
    """
    chance = actors.appearance % 997 / 997.0
    large = np.isin(actors.category, ("Van", "Truck", "Misc", "Tram"))
    return (chance < _UNDECIDED_AT_BORDER) & (truncation > 0.0) | (chance < _UNDECIDED) & large


def boxes_in_camera(
    actors: Actors, rig: SensorRig, vehicle_to_world: Floats
) -> tuple[Floats, Floats]:
    """Bottom centres in the camera frame, shape (N, 3), and rotation_y, shape (N,)."""
    world_to_camera = np.linalg.inv(vehicle_to_world @ rig.camera_to_vehicle)
    centres = np.column_stack([actors.pose[:, :2], actors.z])
    heading = actors.pose[:, 2]
    forward = np.stack([np.cos(heading), np.sin(heading), 0 * heading], axis=-1)
    forward = forward @ world_to_camera[:3, :3].T
    rotation_y = np.arctan2(-forward[:, 2], forward[:, 0])
    return transform_points(world_to_camera, centres), wrap_angle(rotation_y)


def dont_care_boxes(regions: Floats) -> Boxes3D:
    """DontCare lines as KITTI writes them."""
    count = len(regions)
    return Boxes3D(
        location=np.full((count, 3), -1000.0),
        dimensions=np.full((count, 3), -1.0),
        rotation_y=np.full(count, -10.0),
        score=np.ones(count),
        category=np.full(count, "DontCare"),
        box2d=regions,
        truncation=np.full(count, -1.0),
        occlusion=np.full(count, -1.0),
        alpha=np.full(count, -10.0),
    )


def _united(boxes: Floats) -> Floats:
    """Boxes that touch become one, until none do; slivers are left out."""
    rest = [box for box in boxes if min(box[2] - box[0], box[3] - box[1]) > 2.0]
    united: list[Floats] = []
    while rest:
        box = rest.pop()
        for other in united + rest:
            if (np.maximum(box[:2], other[:2]) <= np.minimum(box[2:], other[2:]) + 3.0).all():
                merged = np.r_[np.minimum(box[:2], other[:2]), np.maximum(box[2:], other[2:])]
                united = [kept for kept in united if kept is not other]
                rest = [kept for kept in rest if kept is not other]
                rest.append(merged)
                break
        else:
            united.append(box)
    return np.array(sorted(map(tuple, united))).reshape(-1, 4)
