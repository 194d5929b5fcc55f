"""An instant as one of its vehicles drives through it: alone, or connected with the others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.pipeline import Pipeline, run_episode
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene
from avsec_gym.validation.connected.frame_validator import OWN, frame_of_scans
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.world.export import ConnectedInstant

_FARTHEST = 90.0
"""Metres ahead of the car: KITTI's labels end there."""


@dataclass(frozen=True, eq=False)
class DrivenInstant:
    """One instant, and the scene around the car that drives in it.

    Args:
        scene: What is really there, around vehicle `OWN`.
        calibration: The calibration of its sensors.
    """

    scene: Scene
    calibration: Calibration

    def driven(
        self, pipelines: Mapping[str, Pipeline], instant: RecordedInstant
    ) -> dict[str, list[SafetyRecord]]:
        """What becomes of the car, by the name of its pipeline; a record for each intention.

        Args:
            pipelines: The car with and without connected vehicles.
            instant: What the vehicles scanned, attacked or not.
        """
        frame = frame_of_scans(instant.id, instant.scans, self.calibration)
        return {name: self._records(pipeline, frame) for name, pipeline in pipelines.items()}

    def known(self, pipeline: Pipeline) -> list[SafetyRecord]:
        """What becomes of a car that knows all that is there; a record for each intention.

        Args:
            pipeline: Its planner is asked.
        """
        return [
            run_episode(self.scene, intention, planner=pipeline.planner).record
            for intention in Intention
        ]

    def _records(self, pipeline: Pipeline, frame: SensorFrame) -> list[SafetyRecord]:
        perception = pipeline.perceive(frame)
        return [
            pipeline.run_episode(self.scene, perception, intention).record
            for intention in Intention
        ]


def scene_around(
    truth: ConnectedInstant,
    to_world: Floats,
    calibration: Calibration,
    *,
    id: str,
    road_type: RoadType,
    number: int = 0,
    seed: int = 0,
) -> Scene:
    """The scene ahead of vehicle `OWN` of an instant, as labels have it.

    Args:
        truth: What is there, in the world.
        to_world: The true pose of the vehicle's velodyne, shape (4, 4).
        calibration: The calibration of its sensors.
        id: Id of the scene.
        road_type: Street or highway.
        number: Number of the scene, see `Scene`.
        seed: Seed of the speeds of what moves, see `Scene`.
    """
    own = truth.vehicles[OWN].actor
    objects = [each for each in truth.objects if each.actor != own]
    places = np.array([each.location for each in objects]).reshape(-1, 3)
    heading = np.array([each.heading for each in objects])
    to_camera = calibration.velodyne_to_camera @ np.linalg.inv(to_world)
    location = transform_points(to_camera, places)
    # KITTI's angle turns from the camera's x, to the right, towards the viewer.
    along = np.stack([np.cos(heading), np.sin(heading), np.zeros(len(objects))], axis=1)
    direction = along @ to_camera[:3, :3].T
    boxes = Boxes3D(
        location=location,
        dimensions=np.array([each.dimensions for each in objects]).reshape(-1, 3),
        rotation_y=np.arctan2(-direction[:, 2], direction[:, 0]),
        score=np.ones(len(objects)),
        category=np.array([each.category for each in objects], np.str_),
        moving=np.array([each.moving for each in objects], bool),
    )
    ahead = (location[:, 2] > 0.5) & (location[:, 2] < _FARTHEST)
    return Scene(id, boxes[ahead], road_type, seed, number)
