"""Traffic that tests make: a car on a known path, and objects that stand or drive."""

from __future__ import annotations

import numpy as np

from avsec_gym.closed_loop.recorded.recorded_traffic import RecordedTraffic, recorded_object
from avsec_gym.closed_loop.relative_poses import seen_from
from avsec_gym.geometry import Floats

CAR = np.array([1.5, 1.8, 4.2])


def motion(speed: float, turning: float = 0.0, count: int = 101) -> Floats:
    """Poses of a camera 1.1 m ahead of the rear axle of a car on a circle; the first is zero."""
    time = 0.1 * np.arange(count)
    heading = turning * time
    if turning:
        rear = speed / turning * np.column_stack([np.sin(heading), 1.0 - np.cos(heading)])
    else:
        rear = np.column_stack([speed * time, 0.0 * time])
    ahead = 1.1 * np.column_stack([np.cos(heading) - 1.0, np.sin(heading)])
    return np.column_stack([rear + ahead, heading])


def traffic(
    ego: Floats, world: list[Floats], *, known: bool = False, farthest: float = 60.0
) -> RecordedTraffic:
    """Objects of which each has a pose at every frame, seen by a car while they are ahead of it.

    Args:
        ego: The car's poses, shape (T, 3).
        world: Poses of each object, shape (T, 3) or (3,) for one that stands.
        known: Whether the car's motion is part of the recording.
        farthest: Metres up to which objects are labelled.
    """
    objects = []
    for id, poses in enumerate(world):
        track = np.broadcast_to(poses, (len(ego), 3))
        seen = np.array(
            [seen_from(tuple(own), pose[None])[0] for own, pose in zip(ego, track, strict=True)]
        )
        frames = [i for i, (x, y, _) in enumerate(seen) if abs(y) < x < farthest]
        if not frames:
            continue
        count = len(frames)
        objects.append(
            recorded_object(
                id, "Car", np.tile(CAR, (count, 1)), frames, seen[frames], np.full(count, 1.65)
            )
        )
    return RecordedTraffic("made", len(ego), tuple(objects), ego if known else None)


def parked(*, along: bool = True, against: bool = True) -> list[Floats]:
    """Cars every 12 m at both sides of a street along x."""
    places: list[Floats] = []
    for x in range(10, 150, 12):
        places += [np.array([float(x), -4.0, 0.02])] if along else []
        places += [np.array([x + 5.0, 4.5, np.pi])] if against else []
    return places


def driving(x: float, y: float, speed: float, *, count: int = 101) -> Floats:
    """A car that drives along x, or against it where its speed is negative."""
    way = x + 0.1 * speed * np.arange(count)
    heading = 0.0 if speed > 0 else np.pi
    return np.column_stack([way, np.full(count, y), np.full(count, heading)])
