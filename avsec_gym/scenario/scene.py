"""A scene: what is really around the ego vehicle, before anything is perceived or planned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np

from avsec_gym.argument_checks import keep_read_only
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import (
    build_planning_scenario,
    draw_speeds,
    is_obstacle,
    obstacles_of,
)
from avsec_gym.scenario.constraints import driving_constraints
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.own_road import OwnRoad
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.suggestions import unknown_name


class Motion(StrEnum):
    """What the planner takes as moving."""

    STATIC = "static"
    """Nothing: it plans as if every object stood."""
    TRUTH = "truth"
    """The objects that really move, as they really move; a detected object moves as the true object
    that it overlaps most."""
    CLASSIFIER = "classifier"
    """The boxes whose own `moving` is set, as C sets it: along their headings, at the middle of the
    road type's range of speeds."""

    @classmethod
    def named(cls, name: Motion | str) -> Motion:
        """The one of that name.

        Raises:
            ConfigurationError: There is none.
        """
        try:
            return cls(name)
        except ValueError:
            problem = f"there is no motion {name!r}"
            raise ConfigurationError(unknown_name(problem, str(name), cls)) from None

    @classmethod
    def without_classifier(cls, name: Motion | str) -> Motion:
        """The one of that name, for a car that has no classifier.

        Raises:
            ConfigurationError: There is none, or only a classifier could know it.
        """
        motion = cls.named(name)
        if motion == cls.CLASSIFIER:
            raise ConfigurationError(
                f'motion="{motion}" is what a classifier decides for each box; none is here: '
                f'use "{cls.STATIC}" or "{cls.TRUTH}", or classifier="small" where there are images'
            )
        return motion


@dataclass(frozen=True, eq=False)
class Scene:
    """A labelled frame of one traffic situation.

    Args:
        id: Id of the scene, such as ``000107``.
        boxes: Ground truth with ``moving`` flags.
        road_type: Street or highway.
        seed: The experiment's seed; speeds of moving objects are drawn from it.
        number: The scene's own number, so that scenes draw independently of each other.
        group: A subset that the scene belongs to, such as ``dynamic street``.
        draw_start_speed: Whether the ego vehicle's start speed is drawn from the thesis' range (and
            primitives start there) instead of the authors' 6 or 11 m/s.
        own_road: The road that the scene lies on; None: the thesis' straight lanes.
    """

    id: str
    boxes: Boxes3D
    road_type: RoadType = RoadType.STREET
    seed: int = 0
    number: int = 0
    group: str = ""
    draw_start_speed: bool = False
    own_road: OwnRoad | None = None
    speeds: Floats = field(init=False)
    """Speed of each object along its heading, m/s, shape (N,)."""

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ConfigurationError(f"a seed is 0 or more, got {self.seed}")
        moving = np.zeros(len(self.boxes), bool) if self.boxes.moving is None else self.boxes.moving
        speeds = draw_speeds(moving, self.road_type, self.seed, self.number)
        keep_read_only(self, {"speeds": speeds})

    def __setstate__(self, state: dict[str, Any]) -> None:
        keep_read_only(self, state)

    @property
    def intentions(self) -> tuple[Intention, ...]:
        """The driving intentions that the road has a lane for."""
        return tuple(Intention) if self.own_road is None else self.own_road.intentions

    def possible(self, intentions: Sequence[Intention]) -> tuple[Intention, ...]:
        """The intentions, of some, that the road has a lane for, in their order.

        Raises:
            ConfigurationError: It has none.
        """
        found = tuple(each for each in intentions if each in self.intentions)
        if not found:
            raise ConfigurationError(
                f"{self.id}: no lane of the car's direction lies to the {intentions[0]} on the"
                f" scene's own road; intentions here: {', '.join(self.intentions)}"
            )
        return found

    @property
    def start_speed(self) -> float:
        """The ego vehicle's speed at the start, m/s."""
        return self._start_speed(self.road_type)

    def _start_speed(self, road_type: RoadType) -> float:
        constraints = driving_constraints(road_type)
        if not self.draw_start_speed:
            return constraints.start_speed
        generator = np.random.default_rng([self.seed, self.number, 1])
        return float(generator.uniform(*constraints.start_speed_range))

    def truth(self) -> Obstacles:
        """The real obstacles, moving ones moving: the truth of the collision check."""
        return obstacles_of(self.boxes, self.speeds)

    def problem(
        self,
        intention: Intention,
        believed: Boxes3D | None = None,
        motion: Motion = Motion.TRUTH,
        road_type: RoadType | None = None,
    ) -> PlanningScenario:
        """What the planner is asked when perception believes in certain boxes.

        Args:
            intention: Driving intention.
            believed: Detected boxes; None: the ground truth.
            motion: Knowledge of motion that the planner has.
            road_type: Believed road type; None: the truth.

        Raises:
            ConfigurationError: Motion is to come from a classifier, and the boxes have no `moving`;
                or the road has no lane for the intention.
        """
        self.possible([intention])
        boxes = self.boxes if believed is None else believed
        road_type = self.road_type if road_type is None else road_type
        speeds = None
        if motion == Motion.TRUTH:
            speeds = self.speeds if believed is None else self.speeds_of(believed)
        elif motion == Motion.CLASSIFIER:
            speeds = _classified_speeds(boxes, road_type)
        return build_planning_scenario(
            boxes,
            road_type=road_type,
            intention=intention,
            speeds=speeds,
            start_speed=self._start_speed(road_type),
            id=self.id,
            own_road=self.own_road,
        )

    def speeds_of(self, detected: Boxes3D) -> Floats:
        """How detected boxes move along their headings if they move like what they overlap most.

        A box that overlaps nothing stands; so does one whose own flag states it (a ghost).
        Detectors know headings up to half a turn: a box that faces against its true object's way
        drives backwards.

        Returns:
            m/s, shape (M,).
        """
        sizes = np.stack([self.boxes.length, self.boxes.width], axis=1)
        real = is_obstacle(self.boxes) & np.all(sizes > 0, axis=1)
        return matched_speeds(detected, self.boxes[real], self.speeds[real])


def matched_speeds(detected: Boxes3D, boxes: Boxes3D, speeds: Floats) -> Floats:
    """Speeds of detected boxes along their headings, each that of the true box it overlaps most.

    `Scene.speeds_of` states the rule.

    Args:
        detected: M detected boxes.
        boxes: The true ones, of lengths and widths above 0.
        speeds: Speeds of the true ones along their headings, m/s, shape (N,).

    Returns:
        m/s, shape (M,).
    """
    if not len(boxes) or not len(detected) or not speeds.any():
        return np.zeros(len(detected))
    # numba takes long to import, and most that is done with a scene needs none of it.
    from avsec_gym.box_overlap import rectangle_iou

    overlap = rectangle_iou(
        *(
            np.column_stack([each.poses[:, :2], each.length, each.width, each.poses[:, 2]])
            for each in (detected, boxes)
        )
    )
    best = overlap.argmax(axis=1)
    moves = overlap.max(axis=1) > 0
    if detected.moving is not None:
        moves &= detected.moving
    turned = detected.poses[:, 2] - boxes.poses[best, 2]
    along = speeds[best] * np.where(np.cos(turned) < 0, -1.0, 1.0)
    return np.where(moves, along, 0.0)


def _classified_speeds(boxes: Boxes3D, road_type: RoadType) -> Floats:
    if boxes.moving is None:
        raise ConfigurationError(
            "motion by a classifier needs boxes with `moving`: let C classify them first"
        )
    return np.where(boxes.moving, np.mean(driving_constraints(road_type).others_speed), 0.0)
