"""From the sensors to the collision check: each part is called once, and its answer used."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.attacks.attack import Budget, Seed, Victim
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import ego_to_camera
from avsec_gym.kitti.labels import write_detections
from avsec_gym.pipeline import Pipeline
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Motion, Scene
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation

GREY = np.full((4, 6, 3), 100, np.uint8)
WALL = [[12.0, y, 0.0] for y in (-3.5, 0.0, 3.5)]
"""Cars side by side on all three lanes."""


def cars(poses: list[list[float]], moving: bool = False) -> Boxes3D:
    location, rotation_y = ego_to_camera(np.array(poses, float).reshape(-1, 3), 1.65)
    count = len(rotation_y)
    return Boxes3D(
        location,
        np.tile([1.5, 1.6, 4.0], (count, 1)),
        rotation_y,
        np.ones(count),
        np.full(count, "Car"),
        moving=np.full(count, moving),
    )


def frame() -> SensorFrame:
    projections = np.zeros((4, 3, 4))
    projections[2:] = [[700.0, 0, 3, 0], [0, 700, 2, 0], [0, 0, 1, 0]]
    projections[3, 0, 3] = -370.0
    to_camera = np.array([[0.0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, 0]])
    return SensorFrame("000001", Calibration(projections, np.eye(3), to_camera), {2: GREY, 3: GREY})


@dataclass
class Believer:
    """A detector that sees a wall of cars in bright images, and nothing in others."""

    name: str = "believer"
    seen: list[np.ndarray] = field(default_factory=list)

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.seen.append(frame.stereo().left)
        return cars(WALL) if frame.image(2).mean() > 200 else Boxes3D.empty()

    def detect_batch(self, batch: object) -> list[Boxes3D]:
        return [cars(WALL) if left.mean() > 200 else Boxes3D.empty() for left in batch.left]  # type: ignore[attr-defined]


@dataclass
class Glare:
    """An attack that makes both images bright."""

    name: str = "glare"
    budget: Budget = field(default_factory=lambda: Budget(155.0))
    asked: list[tuple[Victim, Seed]] = field(default_factory=list)

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        self.asked.append((victim, seed))
        for camera in (2, 3):
            frame = frame.with_image(camera, np.full(GREY.shape, 240.4, np.float32))  # type: ignore[arg-type]
        return frame


class Restless:
    """A classifier by which everything moves."""

    def classify(self, boxes: Boxes3D, frame: SensorFrame) -> Boxes3D:
        assert frame.image(2).dtype == np.uint8
        return replace(boxes, moving=np.ones(len(boxes), bool))


class Fast:
    """A selector by which every road is a highway."""

    def select(self, frame: SensorFrame) -> RoadType:
        return RoadType.HIGHWAY


@dataclass
class Watchdog:
    """A validator that barks at bright images; it names one sensor, or says it cannot tell."""

    named: int | str | None = None
    name: str = "watchdog"
    system: SensorSystem = field(default_factory=lambda: SensorSystem((LIDAR, 3, 2)))
    asked: int = 0

    def validate(self, frame: SensorFrame) -> Validation:
        self.asked += 1
        alarm = frame.image(2).mean() > 200
        statuses = dict.fromkeys(self.system.sensors, SensorStatus.SOUND)
        if alarm and self.named is None:
            statuses = dict.fromkeys(statuses, SensorStatus.CANNOT_TELL)
        elif alarm:
            statuses[self.named] = SensorStatus.ATTACKED  # type: ignore[index]
        errors = DisparityErrors(DisparityMaps(frame, self.system))
        return Validation(alarm, statuses, errors)


EMPTY_STREET = Scene("000001", cars([]))


def test_a_camera_delivers_whole_grey_levels() -> None:
    """Of 240.4, what the attack asks for, the detector sees 240."""
    detector = Believer()
    Pipeline(detector, Glare())(EMPTY_STREET, frame())
    assert set(np.unique(detector.seen[-1])) == {240}
    Pipeline(detector, Glare(), whole_levels=False)(EMPTY_STREET, frame())
    assert set(np.unique(detector.seen[-1])) == {np.float32(240.4)}


def test_an_attack_that_conjures_a_wall_stops_the_car() -> None:
    detector, attack = Believer(), Glare()
    clean = Pipeline(detector)(EMPTY_STREET, frame())
    assert clean.episode.record.outcome == "safe"
    begun = time.perf_counter()
    attacked = Pipeline(detector, attack)(EMPTY_STREET, frame(), Intention.LEFT, seed=(3, 1))
    elapsed = time.perf_counter() - begun
    assert attacked.episode.record.outcome == "unplanned"
    assert attacked.frame.image(2).dtype == np.uint8
    victim, seed = attack.asked[0]
    assert victim.detector is detector
    assert victim.truth is EMPTY_STREET.boxes
    assert victim.intention is Intention.LEFT
    assert seed == (3, 1)
    assert {"attack", "detector", "planner"} == set(attacked.seconds)
    assert all(seconds >= 0 for seconds in attacked.seconds.values())
    assert sum(attacked.seconds.values()) <= elapsed


def test_levels_stay_broken_if_asked() -> None:
    detector = Believer()
    Pipeline(detector, Glare(), whole_levels=False)(EMPTY_STREET, frame())
    Pipeline(detector, Glare())(EMPTY_STREET, frame())
    assert detector.seen[0].max() == np.float32(240.4)
    assert detector.seen[1].max() == 240


def test_unsure_detections_are_not_planned_on() -> None:
    class Unsure(Believer):
        def detect(self, frame: SensorFrame) -> Boxes3D:
            return replace(cars(WALL), score=np.array([0.2, 0.29, 0.25]))

    sees = Pipeline(Unsure())(EMPTY_STREET, frame())
    assert (len(sees.perception.detections), len(sees.perception.believed)) == (3, 0)
    assert sees.episode.record.safe
    assert Pipeline(Unsure(), score_threshold=0.1)(EMPTY_STREET, frame()).episode.record.reason


def test_what_the_classifier_says_moves_at_the_middle_of_the_range() -> None:
    seen = frame().with_image(2, GREY + 120)
    pipeline = Pipeline(Believer(), classifier=Restless(), selector=Fast())
    problem = pipeline(EMPTY_STREET, seen).episode.problem
    assert problem.road_type is RoadType.HIGHWAY
    assert problem.start.velocity == 11.0
    assert problem.obstacles.speeds[:, 0].tolist() == [12.0] * 3
    standing = Pipeline(Believer(), motion=Motion.STATIC)(EMPTY_STREET, seen).episode.problem
    assert standing.road_type is RoadType.STREET
    assert not standing.obstacles.speeds.any()


def test_motion_by_a_classifier_needs_one() -> None:
    boxes = replace(cars(WALL), moving=None)
    with pytest.raises(ConfigurationError, match="let C classify"):
        Scene("1", cars([])).problem(Intention.LEFT, boxes, Motion.CLASSIFIER)


def test_many_frames_are_believed_as_each_alone() -> None:
    frames = [frame(), frame().with_image(2, GREY + 120)]
    pipeline = Pipeline(Believer())
    together = pipeline.perceive_all(frames)
    alone = [pipeline.perceive(each) for each in frames]
    assert [len(each.believed) for each in together] == [len(each.believed) for each in alone]
    assert [len(each.believed) for each in together] == [0, 3]


def test_parts_are_found_by_name(tmp_path: Path) -> None:
    write_detections(tmp_path / "000001.txt", cars(WALL))
    pipeline = Pipeline(
        {"name": "replayed", "detections": str(tmp_path)},
        planner="gbfs",
        motion="static",  # type: ignore[arg-type]
    )
    assert pipeline.planner.algorithm == "gbfs"
    assert pipeline(Scene("000001", cars(WALL)), frame()).episode.record.outcome == "unplanned"
    with pytest.raises(ConfigurationError, match="no selector named 'large'"):
        Pipeline("oracle", selector="large")


def test_an_alarm_stops_the_car_before_a_detector_looks() -> None:
    detector, watchdog = Believer(), Watchdog()
    pipeline = Pipeline(detector, Glare(), validator=watchdog)
    run = pipeline(EMPTY_STREET, frame())
    assert run.perception.stops
    assert run.perception.validation is not None
    assert run.perception.validation.alarm
    assert (run.episode.record.outcome, run.episode.record.reason) == ("unplanned", "stopped")
    assert not detector.seen
    assert set(run.seconds) == {"attack", "validator", "planner"}
    near = pipeline(Scene("000001", cars([[6.0, 0.0, 0.0]])), frame()).episode.record
    assert (near.outcome, near.reason) == ("collision", "stopped")


@pytest.mark.parametrize("response", ["stop", "drop", "repair"])
def test_without_alarm_all_is_as_without_validator(response: str) -> None:
    plain = Pipeline(Believer())(EMPTY_STREET, frame())
    watched = Pipeline(Believer(), validator=Watchdog(), response=response)(EMPTY_STREET, frame())
    assert plain.episode.record == watched.episode.record
    assert plain.perception.validation is None
    assert watched.perception.validation is not None
    assert not watched.perception.stops
    assert set(watched.seconds) == {"attack", "validator", "detector", "planner"}


def test_a_camera_detector_goes_on_without_the_lidar_and_stops_without_a_camera() -> None:
    bright = frame().with_image(2, GREY + 120)
    for named, stops in ((LIDAR, False), (3, True), (None, True)):
        pipeline = Pipeline(Believer(), validator=Watchdog(named), response="drop")
        believed = pipeline.perceive(bright)
        assert believed.stops == stops
        assert len(believed.believed) == (0 if stops else 3)


def test_what_the_validator_said_already_is_not_asked_again() -> None:
    watchdog = Watchdog(LIDAR)
    pipeline = Pipeline(Believer(), validator=watchdog, response="drop")
    said = watchdog.validate(frame())
    assert pipeline.perceive(frame(), said).validation is said
    assert watchdog.asked == 1
    assert [perceived.stops for perceived in pipeline.perceive_all([frame(), frame()])] == [
        False,
        False,
    ]
    assert watchdog.asked == 3


def test_optical_attacks_stand_where_attacks_do() -> None:
    facula = {"name": "facula", "camera": 3, "strength": 100.0}
    pipeline = Pipeline(Believer(), facula)
    lit, again = (pipeline.tampered(EMPTY_STREET, frame(), seed=(7, 1)) for _ in range(2))
    assert lit.image(2) is GREY
    assert (lit.image(3) > GREY).any()
    assert (lit.image(3) == again.image(3)).all()


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"no response to an alarm.*stop"):
        Pipeline("oracle", validator=Watchdog(), response="honk")
    with pytest.raises(ConfigurationError, match="no validator named"):
        Pipeline("oracle", validator="cat")
    with pytest.raises(ConfigurationError, match="whole grey levels"):
        Pipeline("oracle", validator=Watchdog(), whole_levels=False)
