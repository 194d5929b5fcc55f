"""How the car comes to its beliefs while it drives: the truth, or sensors and a pipeline.

All levels have one interface, `DrivePerception`.  An attack stands before the detector and a
validator beside it, as in a single query.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.sensor_needs import SensorNeeds
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.pipeline import Perception, Pipeline
from avsec_gym.scenario.scene import Scene


class DrivePerception(Protocol):
    """What the car believes over the course of a drive; it may remember earlier instants."""

    def begin(self, seed: int) -> None:
        """Forget the last drive.

        Args:
            seed: Seed of everything that is left to chance in the next one.
        """

    def perceive(self, surroundings: Surroundings) -> Perception:
        """What the car believes at an instant; called in the order of time."""


class TruthPerception:
    """The car knows everything that is there, and nothing else."""

    def begin(self, seed: int) -> None:
        """Do nothing: there is no chance in it."""

    def perceive(self, surroundings: Surroundings) -> Perception:
        """The true boxes, and whether they move."""
        boxes = replace(surroundings.boxes, moving=np.abs(surroundings.speeds) > 0)
        return Perception(boxes, boxes, surroundings.road_type)


class SensorPerception:
    """A pipeline on what the sensors deliver: attack, validator, detector, classifier, selector.

    Args:
        pipeline: The parts; its planner and its `motion` are not used.
        needs: What of a frame they read.
    """

    frame_by_frame = True
    """What it perceives depends on that frame alone, so that frames without a reader can be left
    out; a `DrivePerception` without this attribute perceives every frame."""

    def __init__(self, pipeline: Pipeline, needs: SensorNeeds = SensorNeeds()) -> None:
        self.pipeline, self.needs = pipeline, needs
        self.frame: SensorFrame | None = None
        """What the sensors delivered last, after the attack; None: nothing yet."""
        self.perceived: Perception | None = None
        """What was made of that."""
        self._seed = 0

    def begin(self, seed: int) -> None:
        """Attacks draw from this seed, at every instant alike: what they put up stays in place."""
        self._seed = seed

    def perceive(self, surroundings: Surroundings) -> Perception:
        """What the pipeline makes of the frame.

        Raises:
            ConfigurationError: The scene has no sensor data.
            DataError: A file of the frame is missing or broken.
        """
        if surroundings.frame is None:
            raise ConfigurationError(
                f"scenario {surroundings.scenario} has no sensor data, which perception by a "
                'detector needs; use perception="truth", or scenes of procedural drives'
            )
        scene = Scene(surroundings.scenario, surroundings.boxes, surroundings.road_type)
        seen = self.pipeline.tampered(
            scene,
            surroundings.frame(),
            surroundings.intention,
            seed=self._seed,
        )
        self.frame, self.perceived = seen, self.pipeline.perceive(seen)
        return self.perceived


class BlindPerception:
    """The car sees nothing at all: the lower end of every comparison."""

    def begin(self, seed: int) -> None:
        """Do nothing: there is no chance in it."""

    def perceive(self, surroundings: Surroundings) -> Perception:
        """No boxes."""
        nothing = replace(Boxes3D.empty(), moving=np.zeros(0, bool))
        return Perception(nothing, nothing, surroundings.road_type)
