"""How often the moving-object classifier and the driving-constraint selector are right.

Run ``python -m studies.perception.classifier_accuracy --world DIR... --kitti ROOT
--scenarios DIR --json FILE``: on held-out scenes of the procedural world, and, apart from them,
on the real frames at hand whose truth the authors of the thesis published.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from avsec_gym.boxes import Boxes3D
from avsec_gym.console import progress
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.json_rows import FLAT, OPTIONAL
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.metrics.clustered_shares import share_of
from avsec_gym.perception.motion.classifier import MovingObjectClassifier, neighbour_of
from avsec_gym.perception.road_type import DrivingConstraintSelector
from avsec_gym.perception.training.motion_samples import OBSTACLES, classified_objects
from avsec_gym.perception.training.scene_frames import scene_frames
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.perception.weights.store import read_card
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.label_list import ROAD_TYPES, read_label_list
from avsec_gym.scenario.scene_sets import labelled_scenarios
from studies.answer import answer

_STREET = 1
"""A street in lists of road types, see `ROAD_TYPES`."""
THESIS = {"motion": 0.9831, "road_type": 0.9464}
"""Section 5.4.1, on the authors' validation data."""

_DISTANCES = ((0.0, 20.0), (20.0, 40.0), (40.0, 1e3))


@dataclass(frozen=True)
class JudgedObject:
    """The classifier's answer for an object, and the truth.

    Args:
        frame: The id of its frame.
        distance: The distance, metres.
        moving: Whether it moves in truth.
        probability: The probability of moving, with a neighbouring frame where there is one.
        single: The probability of moving, by the current crop alone.
        has_neighbour: Whether there was one.
        said: Whether the classifier finds that it moves, by its own rule: with a neighbouring frame
            where there is one.
        said_by_single: The same by the current crop alone, for which the rule is stricter.
        scene: The place and time that several frames are of; None: this frame alone.
    """

    frame: str
    distance: float
    moving: bool
    probability: float
    single: float
    has_neighbour: bool
    said: bool
    said_by_single: bool
    scene: str | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class JudgedType:
    """The selector's answer for a road, and the truth.

    Args:
        scene: The place and time of the frame.
        truth: The true type.
        said: The selector's answer.
    """

    scene: str
    truth: RoadType
    said: RoadType


@dataclass(frozen=True)
class Accuracy:
    """How often a classifier is right."""

    cases: int
    accuracy: float | None
    """None without cases."""
    interval: list[float] | None
    """95 %; cases of one scene belong together."""
    confusion: Mapping[str, int]
    """Such as ``no_said_yes``: the truth, and the classifier's answer."""
    clusters: int | None = field(default=None, metadata=OPTIONAL)
    """Number of scenes that the cases are of; None in earlier results, whose intervals take all
    cases for independent."""


@dataclass(frozen=True)
class MotionAccuracy:
    """How often the moving-object classifier is right."""

    with_neighbour: Accuracy
    single_crop: Accuracy
    single_crop_of_the_same: Accuracy
    """The single crops of the objects that have a neighbouring frame, too."""
    by_distance: Mapping[str, Accuracy]


@dataclass(frozen=True)
class WorldMotion:
    """Accuracy of motion in the procedural world."""

    scenes: int
    accuracy: MotionAccuracy = field(metadata=FLAT)


@dataclass(frozen=True)
class WorldRoads:
    """The driving-constraint selector in the procedural world; yes is a highway."""

    scenes: int
    accuracy: Accuracy = field(metadata=FLAT)


@dataclass(frozen=True)
class RealMotion:
    """Accuracy of motion in real frames, with their objects."""

    frames: list[str]
    accuracy: MotionAccuracy = field(metadata=FLAT)
    objects: list[JudgedObject]


@dataclass(frozen=True)
class JudgedRoad:
    """A real frame's road."""

    frame: str
    truth: str
    highway: float
    """The probability of a highway."""
    has_cars: bool = field(default=True, metadata=OPTIONAL)
    """Whether the scenario has cars; those without are streets by their folder, and the lists of
    road types leave them out."""


@dataclass(frozen=True)
class RealRoads:
    """The driving-constraint selector on real frames; yes is a highway."""

    accuracy: Accuracy = field(metadata=FLAT)
    frames: list[JudgedRoad]


@dataclass(frozen=True)
class MotionResult:
    """The moving-object classifier; what was not asked for is None."""

    thesis: float
    weights: str | None
    """Their sha256."""
    world: WorldMotion | None = field(default=None, metadata=OPTIONAL)
    real: Mapping[str, RealMotion] | None = field(default=None, metadata=OPTIONAL)
    """Results on real crops by the kind of truth."""


@dataclass(frozen=True)
class RoadResult:
    """The driving-constraint selector; what was not asked for is None."""

    thesis: float
    weights: str | None
    """Their sha256."""
    world: WorldRoads | None = field(default=None, metadata=OPTIONAL)
    real: RealRoads | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class ClassifierAccuracy:
    """The result."""

    motion: MotionResult
    road_type: RoadResult


def run(options: argparse.Namespace) -> ClassifierAccuracy:
    """Measure everything that the options name.

    Raises:
        ConfigurationError: They name nothing.
        DataError: A file is broken.
    """
    if not options.world and options.kitti is None:
        raise ConfigurationError("there is nothing to judge: give --world DIR or --kitti ROOT")
    if (options.kitti is None) != (options.scenarios is None):
        raise ConfigurationError("--kitti and --scenarios go together: images, and their truth")
    classifier = MovingObjectClassifier(weights=options.motion_weights)
    selector = DrivingConstraintSelector(weights=options.road_type_weights)
    motion = MotionResult(THESIS["motion"], _hash(options.motion_weights))
    road = RoadResult(THESIS["road_type"], _hash(options.road_type_weights))
    if options.world:
        world = [
            frame for root in options.world for frame in scene_frames(root, options.split or None)
        ]
        scenes = len({labelled.scene for labelled in world})
        objects: list[JudgedObject] = []
        roads = []
        with progress("judging") as shown:
            for done, labelled in enumerate(world, start=1):
                frame, boxes = labelled.frame(), labelled.boxes()
                objects += judged(
                    classifier, frame, boxes[classified_objects(boxes)], labelled.scene
                )
                roads.append(JudgedType(labelled.scene, labelled.road_type, selector.select(frame)))
                shown(done, len(world))
        motion = replace(motion, world=WorldMotion(scenes, _motion_summary(objects)))
        road = replace(road, world=WorldRoads(scenes, _road_summary(roads)))
    if options.kitti is not None:
        moving = _real_motion(classifier, options.kitti, options.scenarios)
        motion = replace(motion, real=moving)
        road = replace(road, real=_real_roads(selector, options.kitti, options.scenarios))
    return ClassifierAccuracy(motion, road)


def judged(
    classifier: MovingObjectClassifier, frame: SensorFrame, boxes: Boxes3D, scene: str | None = None
) -> list[JudgedObject]:
    """The classifier's results for a frame's objects, with `moving` as truth.

    Args:
        classifier: The classifier.
        frame: The frame.
        boxes: Its objects, `moving` set.
        scene: The place and time that it is of; None: no other frame is of it.
    """
    if not len(boxes):
        return []
    assert boxes.moving is not None, "the truth"
    has_neighbour = neighbour_of(frame, boxes) is not None
    alone = replace(frame, previous=())
    columns = zip(
        boxes.location[:, 2],
        boxes.moving,
        classifier.probabilities(boxes, frame),
        classifier.probabilities(boxes, alone),
        _moving(classifier, boxes, frame),
        _moving(classifier, boxes, alone),
        strict=True,
    )
    return [
        JudgedObject(
            frame.id, round(float(z), 1), bool(moves), round(float(p), 4), round(float(q), 4),
            has_neighbour, bool(said), bool(said_by_single), scene,
        )
        for z, moves, p, q, said, said_by_single in columns
    ]  # fmt: skip


def _moving(
    classifier: MovingObjectClassifier, boxes: Boxes3D, frame: SensorFrame
) -> NDArray[np.bool_]:
    moving = classifier.classify(boxes, frame).moving
    assert moving is not None, "set by the classifier"
    return moving


def counted(truth: Sequence[bool], said: Sequence[bool], scenes: Sequence[str]) -> Accuracy:
    """Accuracy with its interval, and the confusion.

    Args:
        truth: What is true of each case.
        said: The classifier's answer.
        scenes: The scene of each case; cases of one are a cluster.
    """
    pairs = list(zip(truth, said, strict=True))
    right = share_of([a == b for a, b in pairs], scenes)
    return Accuracy(
        cases=right.of,
        accuracy=right.rate,
        interval=None if right.interval is None else list(right.interval),
        confusion={
            f"{_word(a)}_said_{_word(b)}": pairs.count((a, b))
            for a in (False, True)
            for b in (False, True)
        },
        clusters=len(set(scenes)),
    )


def _word(answer: bool) -> str:
    return "yes" if answer else "no"


def _motion_summary(objects: Sequence[JudgedObject]) -> MotionAccuracy:
    def of(chosen: Iterable[JudgedObject], single: bool = False) -> Accuracy:
        chosen = list(chosen)
        said = [seen.said_by_single if single else seen.said for seen in chosen]
        scenes = [seen.scene or seen.frame for seen in chosen]
        return counted([seen.moving for seen in chosen], said, scenes)

    neighboured = [seen for seen in objects if seen.has_neighbour]
    return MotionAccuracy(
        with_neighbour=of(neighboured),
        single_crop=of(objects, single=True),
        single_crop_of_the_same=of(neighboured, single=True),
        by_distance={
            f"{near:.0f}-{far:.0f} m": of(
                seen for seen in neighboured if near <= seen.distance < far
            )
            for near, far in _DISTANCES
        },
    )


def _road_summary(roads: Sequence[JudgedType]) -> Accuracy:
    """Yes is a highway."""
    return counted(
        [road.truth is RoadType.HIGHWAY for road in roads],
        [road.said is RoadType.HIGHWAY for road in roads],
        [road.scene for road in roads],
    )


def _real_motion(
    classifier: MovingObjectClassifier, kitti: Path, scenarios: Path
) -> dict[str, RealMotion]:
    """Objects of the frames that have an image, apart for the two kinds of truth."""
    data = KittiObject(kitti)
    ids = data.ids(having=("image_2", "label_2", "calib"))
    flags = {
        scene.id: scene.boxes for scene in labelled_scenarios(scenarios).labelled if scene.id in ids
    }
    static = {id for id in _static_frames(scenarios) if id in ids and id not in flags}
    by_list = {id: _all_standing(data.labels(id)) for id in sorted(static)}
    result: dict[str, RealMotion] = {}
    for name, truth in (("flags_of_scenarios", flags), ("static_by_list", by_list)):
        objects: list[JudgedObject] = []
        for id, boxes in sorted(truth.items()):
            chosen = boxes[classified_objects(boxes)]
            objects += judged(classifier, data.frame(id), chosen)
        result[name] = RealMotion(sorted(truth), _motion_summary(objects), objects)
    return result


def _real_roads(selector: DrivingConstraintSelector, kitti: Path, scenarios: Path) -> RealRoads:
    data = KittiObject(kitti)
    there = set(data.ids(having=("image_2", "calib")))
    labels = _lists(scenarios / "road_type")
    without_cars = {file.stem for file in (scenarios / "nocar").glob("*.txt")} - labels.keys()
    labels |= dict.fromkeys(without_cars, _STREET)
    frames: list[JudgedRoad] = []
    pairs = []
    for id in sorted(there & labels.keys()):
        frame, truth = data.frame(id), ROAD_TYPES[labels[id]]
        pairs.append(JudgedType(id, truth, selector.select(frame)))
        highway = round(selector.highway_probability(frame), 4)
        frames.append(JudgedRoad(id, str(truth), highway, id not in without_cars))
    return RealRoads(_road_summary(pairs), frames)


def _static_frames(scenarios: Path) -> set[str]:
    """Frames none of whose objects moves, by the authors' list of crops."""
    labels: dict[str, set[int]] = defaultdict(set)
    for image, label in _lists(scenarios / "moving_object").items():
        labels[image.partition("_")[0]].add(label)
    return {id for id, seen in labels.items() if seen == {0}}


def _all_standing(boxes: Boxes3D) -> Boxes3D:
    boxes = boxes[np.isin(boxes.category, OBSTACLES)]
    return replace(boxes, moving=np.zeros(len(boxes), bool))


def _lists(folder: Path) -> dict[str, int]:
    """Labels by image of all lists of a folder."""
    lists = sorted(folder.glob("*.csv"))
    if not lists:
        raise DataError(
            "No list of images is here.",
            path=folder,
            remedy="It belongs to the labelled scenarios of the thesis' authors.",
        )
    return {image: label for path in lists for image, label in read_label_list(path).items()}


def _hash(path: Path) -> str | None:
    card = read_card(path)
    return None if card is None else card.sha256


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument(
        "--world", type=Path, nargs="*", default=[], help="folders of the procedural world"
    )
    parser.add_argument("--split", default="val", help="of them; '' for all (default: val)")
    parser.add_argument("--kitti", type=Path, help="real frames: root of the object benchmark")
    parser.add_argument("--scenarios", type=Path, help="the authors' labelled scenarios")
    parser.add_argument("--motion-weights", type=Path, default=shipped_weights("motion_small"))
    parser.add_argument(
        "--road-type-weights", type=Path, default=shipped_weights("road_type_small")
    )
    parser.add_argument("--json", type=Path, help="file for the result; default: standard output")
    options = parser.parse_args(arguments)
    return answer(options, run)


if __name__ == "__main__":
    sys.exit(main())
