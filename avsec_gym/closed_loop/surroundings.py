"""What is really around the car at one instant, and how its sensors would see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.relative_poses import Pose, seen_from
from avsec_gym.closed_loop.traffic_scene import SensorRenderer, TrafficScene
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, ego_to_camera
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import EgoState


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The truth at one instant of a drive; perception makes beliefs of it.

    Args:
        time: Seconds since the start of the drive.
        pose: x, y, heading of the car's centre in the world frame.
        speed: The car's speed, m/s.
        boxes: All others, in the camera frame of the car at this instant; the camera stands at the
            car's centre, as in the thesis' conversion of labels.
        speeds: Speed of each along its heading, m/s, shape (N,).
        actors: Id of each, the same over the whole drive, shape (N,).
        road_type: Street or highway.
        intention: Where the car wants to go; attacks may depend on it.
        scenario: Id of the scene.
        frame: Function that renders or reads what the sensors deliver; None: there is no sensor
            data.
    """

    time: float
    pose: Pose
    speed: float
    boxes: Boxes3D
    speeds: Floats
    actors: NDArray[np.int64]
    road_type: RoadType
    intention: Intention = Intention.STRAIGHT
    scenario: str = ""
    frame: Callable[[], SensorFrame] | None = None


@dataclass(frozen=True, eq=False)
class ActorStates:
    """All actors of a scene at one instant, in the order of its tracks; N of them.

    Args:
        poses: x, y, heading in the world frame, shape (N, 3).
        speeds: Speeds along the headings, m/s, shape (N,).
        present: Whether each is there, shape (N,).
    """

    poses: Floats
    speeds: Floats
    present: NDArray[np.bool_]

    def around(
        self, scene: TrafficScene, state: EgoState, elapsed: float, intention: Intention
    ) -> Surroundings:
        """The truth at this instant, as it lies around a car.

        Args:
            scene: The scene.
            state: The car's state.
            elapsed: Seconds since the start of the drive.
            intention: Where the car wants to go.
        """
        tracks, there, sensors = scene.tracks, self.present, scene.sensors
        pose = (state.x, state.y, state.heading)
        ids, poses, speeds = tracks.ids[there], self.poses[there], self.speeds[there]
        location, rotation_y = ego_to_camera(seen_from(pose, poses), tracks.below[there])
        boxes = Boxes3D(
            location=location.reshape(len(ids), 3),
            dimensions=tracks.dimensions[there],
            rotation_y=rotation_y,
            score=np.ones(len(ids)),
            category=tracks.categories[there],
            moving=np.abs(speeds) > 0,
        )

        def frame(deliver: SensorRenderer) -> SensorFrame:
            others = {
                int(id): (float(x), float(y), float(heading))
                for id, (x, y, heading) in zip(ids, poses, strict=True)
            }
            return deliver(elapsed, pose, others)

        return Surroundings(
            time=elapsed,
            pose=pose,
            speed=state.velocity,
            boxes=boxes,
            speeds=speeds,
            actors=ids,
            road_type=scene.road_type,
            intention=intention,
            scenario=scene.id,
            frame=None if sensors is None else partial(frame, sensors),
        )
