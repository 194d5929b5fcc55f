"""Parts of somebody else's: a plug-in that tests install beside the package, in other processes.

A module of its own, not a test; `install` in test_plugins.py writes its entry point.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from avsec_gym import register
from avsec_gym.attacks.attack import Budget, Victim
from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.planners.plan import Plan, Status
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.sensor_system import LIDAR, Sensor, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation

BRIGHT = 200.0
"""Mean grey level from which on an image is taken to be attacked."""


@dataclass(frozen=True)
class Planner:
    """Plans as A* does, in its own patience; without any it gives up."""

    patience: int = 100_000

    def plan(self, scenario: PlanningScenario) -> Plan:
        if not self.patience:
            return Plan(Status.LIMIT)
        return replace(MotionPrimitivePlanner().plan(scenario), expanded=4242)


@dataclass(frozen=True)
class Detector:
    """Sees one car in the way in the dark, and nothing in a bright image."""

    name: ClassVar[str] = "mine"
    distance: float = 14.0

    def detect(self, frame: SensorFrame) -> Boxes3D:
        if frame.image(2).mean() > BRIGHT:
            return Boxes3D.empty()
        return Boxes3D(
            [[0.0, 1.65, self.distance]], [[1.5, 1.6, 4.0]], [-np.pi / 2], [0.9], ["Car"],
            box2d=[[100.0, 40.0, 140.0, 80.0]], truncation=[0.0], occlusion=[0], alpha=[0.0],
        )  # fmt: skip


@dataclass(frozen=True)
class Glare:
    """A camera sees nothing but white."""

    name: ClassVar[str] = "glare"
    camera: int = 2

    @property
    def sensors(self) -> frozenset[Sensor]:
        return frozenset({self.camera})

    def attack(self, frame: SensorFrame, seed: object = 0) -> TamperedFrame:
        white = np.full_like(frame.image(self.camera), 255)
        where = np.ones(white.shape[:2], bool)
        return TamperedFrame(frame.with_image(self.camera, white), pixels={self.camera: where})


@dataclass(frozen=True)
class Blinding:
    """The same of both cameras, as an attack on detectors."""

    name: ClassVar[str] = "blinding"
    level: int = 255

    @property
    def budget(self) -> Budget:
        return Budget(255.0)

    def attack(self, frame: SensorFrame, victim: Victim, seed: object = 0) -> SensorFrame:
        assert len(victim.truth) == 1, "the labels of the scene"
        for camera in (2, 3):
            frame = frame.with_image(camera, np.full_like(frame.image(camera), self.level))
        return frame


@dataclass(frozen=True)
class Validator:
    """Blames every camera that is bright."""

    name: ClassVar[str] = "mine"
    system: ClassVar[SensorSystem] = SensorSystem((LIDAR, 3, 2))
    bright: float = BRIGHT

    def validate(self, frame: SensorFrame) -> Validation:
        blamed = {one for one in (2, 3) if frame.image(one).mean() > self.bright}
        statuses = {
            sensor: SensorStatus.ATTACKED if sensor in blamed else SensorStatus.SOUND
            for sensor in self.system.sensors
        }
        return Validation(
            bool(blamed), statuses, DisparityErrors(DisparityMaps(frame, self.system))
        )


def load() -> None:
    register("planner", "mine", Planner)
    register("detector", "mine", Detector)
    register("optical_attack", "glare", Glare)
    register("attack", "blinding", Blinding)
    register("validator", "mine", Validator)
