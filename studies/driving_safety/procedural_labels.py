"""Procedural drives as tracking labels with known motion: what estimates are held against."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.recorded.recorded_motion import from_first
from avsec_gym.geometry import Floats, ego_to_camera, rectangle_corners
from avsec_gym.kitti.tracking import TrackedBoxes
from avsec_gym.world.drives import DriveScenes

_VIEW = np.radians(40.0)
"""Half of the camera's field of view."""
_FARTHEST, _NEAREST = 70.0, 2.0
"""Metres between which objects are labelled, as KITTI's annotators did."""
_HIDDEN = 0.7
"""Share of an object's width, seen from the camera, that others may hide."""
_NOISE, _NOISE_PER_METRE, _NOISE_OF_HEADING = 0.05, 0.003, np.radians(1.0)
"""Standard deviations of labels: m, m for each m of distance, rad."""
_BELOW = 1.65


def drive_labels(
    scenes: DriveScenes, seed: int, *, noisy: bool = True
) -> tuple[dict[int, TrackedBoxes], Floats]:
    """Labels of all frames, and the true motion of the camera.

    Args:
        scenes: The drive; nothing of it is rendered.
        seed: Seed of the labels' errors.
        noisy: Whether labels have errors.

    Returns:
        By frame the objects in the camera's view that others do not hide, in the camera frame; and
        poses x, y (m), heading (rad, without jumps) of the camera, shape (T, 3), the first zero.
    """
    generator = np.random.default_rng(seed)
    camera = scenes.world.ego_poses[:, 0] @ scenes.rig.camera_pose(0)
    forward = camera[:, :2, 2]
    headings = np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))
    motion = np.column_stack([camera[:, :2, 3], headings])
    frames = {}
    for frame, instant in enumerate(scenes.world.instants):
        actors = instant.actors
        others = np.ones(len(actors), bool)
        others[list(instant.egos)] = False
        poses = from_first(np.vstack([motion[frame], actors.pose[others]]))[1:]
        sizes = actors.dimensions[others]
        seen = _seen(poses, sizes)
        poses, sizes = poses[seen], sizes[seen]
        if noisy:
            poses = poses + _errors(poses, generator)
        location, rotation_y = ego_to_camera(poses, np.full(len(poses), _BELOW))
        boxes = Boxes3D(
            location=location.reshape(-1, 3),
            dimensions=sizes,
            rotation_y=rotation_y,
            score=np.ones(len(poses)),
            category=actors.category[others][seen],
        )
        frames[frame] = TrackedBoxes(boxes, np.asarray(actors.id)[others][seen])
    return frames, from_first(motion)


def _errors(poses: Floats, generator: np.random.Generator) -> Floats:
    spread = _NOISE + _NOISE_PER_METRE * np.hypot(poses[:, 0], poses[:, 1])
    drawn = generator.standard_normal((len(poses), 3))
    return np.asarray(
        drawn * np.column_stack([spread, spread, np.full(len(poses), _NOISE_OF_HEADING)])
    )


def _seen(poses: Floats, sizes: Floats) -> NDArray[np.bool_]:
    """Whether each object lies in view, and nearer ones leave enough of it to be seen."""
    distance = np.hypot(poses[:, 0], poses[:, 1])
    bearing = np.arctan2(poses[:, 1], poses[:, 0])
    seen = (np.abs(bearing) < _VIEW) & (distance > _NEAREST) & (distance < _FARTHEST)
    corners = rectangle_corners(poses, sizes[:, 2], sizes[:, 1])
    angles = np.arctan2(corners[..., 1], corners[..., 0])
    # A fine fan of rays: each belongs to the nearest object that it meets.
    rays = np.arange(-_VIEW, _VIEW, np.radians(0.1))
    meets = (angles.min(axis=1)[:, None] <= rays) & (rays <= angles.max(axis=1)[:, None])
    meets &= (poses[:, 0] > 0)[:, None]
    first = np.where(meets, distance[:, None], np.inf).argmin(axis=0) if len(poses) else rays
    own = (meets & (first == np.arange(len(poses))[:, None])).sum(axis=1)
    return np.asarray(seen & (own > (1.0 - _HIDDEN) * np.maximum(meets.sum(axis=1), 1)))
