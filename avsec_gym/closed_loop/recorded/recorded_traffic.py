"""Recorded traffic: tracked objects as the recording car saw them, ten times a second."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats


@dataclass(frozen=True, eq=False)
class RecordedObject:
    """One object in the frames that it is labelled in.

    Args:
        id: Number of the object in the recording.
        category: KITTI's name, such as ``Car``.
        dimensions: Height, width, length, metres, shape (3,): the median over its labels.
        frames: Numbers of the frames, sorted, shape (n,).
        poses: x forward, y left (m), heading (rad, without jumps) in the frame of the recording
            car, whose origin is the camera, shape (n, 3).
        below: How far its bottom lies below the camera, metres: the median over its labels.
    """

    id: int
    category: str
    dimensions: Floats
    frames: NDArray[np.int64]
    poses: Floats
    below: float


@dataclass(frozen=True, eq=False)
class RecordedTraffic:
    """The labelled objects of a sequence or drive.

    Args:
        id: Name of the sequence or drive.
        count: Number of frames, a tenth of a second apart.
        objects: What is labelled.
        motion: The car's poses x, y (m), heading (rad, without jumps) at every frame, in a plane
            with x forward and y left at the first, shape (count, 3); None: it was not recorded.
    """

    id: str
    count: int
    objects: tuple[RecordedObject, ...]
    motion: Floats | None = None


def recorded_object(
    id: int, category: str, dimensions: Floats, frames: list[int], poses: Floats, below: Floats
) -> RecordedObject:
    """One object, of its labels in any order.

    Args:
        id: Number of the object in the recording.
        category: KITTI's name.
        dimensions: Height, width, length of each label, shape (n, 3).
        frames: Frame of each label.
        poses: Pose of each label in the car's frame, shape (n, 3).
        below: How far the bottom lies below the camera, shape (n,).
    """
    order = np.argsort(frames)
    ordered = np.array(poses, float)[order]
    ordered[:, 2] = np.unwrap(ordered[:, 2])
    return RecordedObject(
        id,
        category,
        np.median(dimensions, axis=0),
        np.asarray(frames, np.int64)[order],
        ordered,
        float(np.median(below)),
    )


def world_poses(each: RecordedObject, poses: Floats) -> Floats:
    """An object's poses in the world, shape (n, 3).

    Args:
        each: The object.
        poses: The car's poses at every frame, shape (T, 3).
    """
    own = poses[each.frames]
    cos, sin = np.cos(own[:, 2]), np.sin(own[:, 2])
    x, y, heading = each.poses.T
    return np.column_stack(
        [own[:, 0] + cos * x - sin * y, own[:, 1] + sin * x + cos * y, own[:, 2] + heading]
    )
