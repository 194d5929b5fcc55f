"""Both classifiers' tasks, on painted frames in the layout that the procedural world writes.

A textured wall at one depth, and on it two patches: one stands; the other was elsewhere a
frame before.  Streets are dark, highways bright.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.perception.motion.classifier import MovingObjectClassifier
from avsec_gym.perception.motion.network import MotionConfiguration
from avsec_gym.perception.training.configuration import (
    Augmentation,
    TrainingConfiguration,
)
from avsec_gym.perception.training.motion_samples import (
    MotionSamples,
    classified_objects,
    disturbed,
    prepare_motion_samples,
)
from avsec_gym.perception.training.motion_task import MotionTask, motion_task
from avsec_gym.perception.training.scene_frames import SceneFrame, split_by_scene
from avsec_gym.perception.training.tasks import TaskOptions, make_task
from avsec_gym.perception.training.trainer import train
from avsec_gym.rig import KITTI_CAMERAS, camera_rig
from avsec_gym.road_type import RoadType

pytestmark = pytest.mark.usefixtures("undrawn_curves")

RIG = camera_rig(KITTI_CAMERAS, focal_length=360.0, centre=(310.0, 86.3), size=(621, 187))
CALIBRATION = RIG.calibration
DEPTH = 12.0
FRAMES = 16
SMALL = MotionConfiguration(
    ((8,), (16,), (16,)), crop=(32, 32), neighbour=True, hidden=16, dropout=0.1, normalised=True
)
PLACES = (150, 400)
"""Columns of the two patches' middles."""


def wall(number: int, shift: int, patches: tuple[int, ...], brightness: int) -> Image:
    """The wall with its patches, all moved to the left by a shift, pixels."""
    rng = np.random.default_rng(number)
    height, width = RIG.size[1], RIG.size[0] + 100
    image = np.zeros((height, width, 3))
    for blur in (1.0, 3.0):
        noise = cv2.GaussianBlur(rng.standard_normal((height, width)), None, blur)
        image += (brightness + 25 * noise / noise.std())[..., None] / 2
    for patch in patches:
        image[80:120, patch - 30 : patch + 30] = 40 + 170 * rng.random((5, 6, 3)).repeat(
            8, axis=0
        ).repeat(10, axis=1)
    moved = image[:, shift : shift + RIG.size[0]]
    return np.clip(moved, 0, 255).astype(np.uint8)


def boxes(moving: tuple[bool, bool]) -> Boxes3D:
    projection = CALIBRATION.projection(2)
    box2d = np.array([[middle - 30.0, 80.0, middle + 30.0, 120.0] for middle in PLACES])
    middle = np.column_stack([box2d[:, [0, 2]].mean(axis=1), box2d[:, 3]])
    rays = np.column_stack([middle, np.ones(2)]) @ np.linalg.inv(projection[:, :3]).T
    return Boxes3D(
        location=rays * DEPTH + [0.0, 0.0, 0.1],
        dimensions=np.array([[1.3, 2.0, 0.2]] * 2),
        rotation_y=np.full(2, -np.pi / 2),
        score=np.ones(2),
        category=np.array(["Car", "Van"]),
        box2d=box2d,
        truncation=np.zeros(2),
        occlusion=np.zeros(2),
        alpha=np.zeros(2),
        moving=np.array(moving),
    )


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Every fourth frame is for validation; each patch moves in some."""
    root = tmp_path_factory.mktemp("world")
    folder = root / "training"
    disparity = round(CALIBRATION.focal_length() * CALIBRATION.baseline() / DEPTH)
    splits: dict[str, list[str]] = {"train": [], "val": []}
    for number in range(FRAMES):
        id, road = f"{number:06d}", tuple(RoadType)[number // 4 % 2]
        moving = (number % 3 == 0, number % 5 < 2)
        light = 80 if road is RoadType.STREET else 170
        before = tuple(p + 14 * moves for p, moves in zip(PLACES, moving, strict=True))
        earlier = SensorFrame(f"{id}_01", CALIBRATION, {2: wall(number, 0, before, light)})
        images = {2: wall(number, 0, PLACES, light), 3: wall(number, disparity, PLACES, light)}
        frame = SensorFrame(id, CALIBRATION, images, previous=(earlier,))
        write_object_frame(folder, frame, boxes(moving))
        facts = {"road_type": road, "objects": [{"moving": moves} for moves in moving]}
        (folder / "scene").mkdir(exist_ok=True)
        (folder / "scene" / f"{id}.json").write_text(json.dumps(facts))
        splits["val" if number % 4 == 3 else "train"].append(id)
    (root / "ImageSets").mkdir()
    for name, ids in splits.items():
        (root / "ImageSets" / f"{name}.txt").write_text("\n".join(ids) + "\n")
    return root


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def samples(root: Path, cache: Path) -> tuple[MotionSamples, MotionSamples]:
    split = split_by_scene([root])
    training, validation = (
        prepare_motion_samples(part, SMALL, cache) for part in (split.training, split.validation)
    )
    return training, validation


def task_of(samples: tuple[MotionSamples, MotionSamples]) -> MotionTask:
    torch.manual_seed(0)
    return MotionTask(MovingObjectClassifier(SMALL, None), *samples, Augmentation(), {})


def test_frames_know_their_truth_and_scenes_are_held_out(root: Path) -> None:
    split = split_by_scene([root])
    assert (len(split.training), len(split.validation)) == (12, 4)
    assert not {m.scene for m in split.training} & {m.scene for m in split.validation}
    first: SceneFrame = split.training[0]
    assert first.id == "000000"
    moving = first.boxes().moving
    assert moving is not None
    assert moving.tolist() == [True, True]
    assert first.road_type is RoadType.STREET
    assert len(first.frame().previous) == 1
    everything = split_by_scene([root], [root])
    assert len(everything.training) == len(everything.validation) == FRAMES


def test_frames_that_do_not_state_the_truth_are_refused(root: Path, tmp_path: Path) -> None:
    first = split_by_scene([root]).training[0]
    facts = tmp_path / "facts.json"
    for text, message in (("{", "no sound JSON"), ('{"objects": []}', "no scene file")):
        facts.write_text(text)
        with pytest.raises(DataError, match=message):
            replace(first, facts=facts).boxes()


def test_samples_are_cut_once_and_what_stood_looks_the_same(
    samples: tuple[MotionSamples, MotionSamples], root: Path, cache: Path
) -> None:
    training, _ = samples
    assert len(training) == 24
    assert training.known.all()
    change = np.abs(training.before[:, 0, 0, 0].astype(float) - training.now[:, 0])
    middle = change[:, 10:-10, 10:-10].mean(axis=(1, 2, 3))
    assert middle[~training.moving].max() < middle[training.moving].min()
    there = {path: path.stat().st_mtime_ns for path in cache.iterdir()}
    again = prepare_motion_samples(split_by_scene([root]).training, SMALL, cache)
    assert np.array_equal(again.now, training.now)
    assert {path: path.stat().st_mtime_ns for path in cache.iterdir()} == there


def test_who_is_no_obstacle_or_cannot_be_seen_is_not_learned() -> None:
    two = boxes((True, False))
    assert two.box2d is not None
    assert classified_objects(two).tolist() == [True, True]
    changed = (
        replace(two, category=np.array(["Car", "Pedestrian"])),
        replace(two, box2d=two.box2d - [[0, 0, 0, 0], [0, 0, 0, 30]]),
        replace(two, truncation=np.array([0.0, 0.9])),
        replace(two, occlusion=np.array([0.0, 3.0])),
    )
    for other in changed:
        assert classified_objects(other).tolist() == [True, False]


def test_disturbed_boxes_err_along_the_ray_most() -> None:
    many = Boxes3D.concatenate([boxes((True, False))] * 500)
    errors = disturbed(many, np.random.default_rng(0)).location - many.location
    assert errors[:, 2].std() == pytest.approx(0.03 * DEPTH, rel=0.2)
    assert errors[:, 1].std() < 0.1


def test_batches_repeat_and_vary(samples: tuple[MotionSamples, MotionSamples]) -> None:
    task = task_of(samples)
    one, same, other = (
        task.batch([0, 1, 2] * 20, np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    assert torch.equal(one.crops.now, same.crops.now)
    assert torch.equal(one.crops.before, same.crops.before)
    assert not torch.equal(one.crops.now, other.crops.now)
    assert one.crops.now.shape == (60, 3, *SMALL.crop)
    assert 0.6 < one.crops.known.float().mean() < 1.0, "some are judged by the single crop"
    assert set(task.losses(one)) == {"entropy"}


@pytest.mark.slow
def test_learns_what_only_the_neighbour_tells(
    samples: tuple[MotionSamples, MotionSamples], tmp_path: Path
) -> None:
    task = task_of(samples)
    train(task, TrainingConfiguration(epochs=60, batch=12, average=0.9, seed=1), tmp_path)
    metrics = task.validate()
    assert metrics["accuracy"] > 0.9
    assert metrics["single_balanced_accuracy"] < 0.8


def test_options_make_the_tasks(root: Path, cache: Path) -> None:
    task = motion_task(TaskOptions("small", (root,), (), cache))
    assert task.samples == 24
    assert task.description()["data"]["objects"] == {"training": 24, "validation": 8}
    assert json.dumps(task.description())
    with pytest.raises(ConfigurationError):
        motion_task(TaskOptions("large", (root,), (), cache))


@pytest.mark.slow
def test_road_types_are_learned_from_the_same_frames(
    root: Path, cache: Path, tmp_path: Path
) -> None:
    task = make_task("road_type", TaskOptions("small", (root,), (), cache))
    assert task.samples == 12
    assert json.dumps(task.description())
    configuration = TrainingConfiguration(epochs=8, batch=6, average=0.5, seed=1)
    train(task, configuration, tmp_path)
    assert task.validate()["balanced_accuracy"] == 1.0
