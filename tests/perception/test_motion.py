"""The moving-object classifier: what it sees of objects, and how the ego vehicle's motion is found.

Scenes are painted by hand: a textured wall, or a ground and boxes, seen by KITTI's rig from two
places, so that the true motion and the true place of every pixel are known.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.geometry import Floats, project, transform_points
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.perception.motion.classifier import MovingObjectClassifier, neighbour_of
from avsec_gym.perception.motion.crops import current_crops, earlier_crops, object_regions
from avsec_gym.perception.motion.displacement import LEAST, likeliest_ways
from avsec_gym.perception.motion.ego_motion import ego_motion
from avsec_gym.perception.motion.network import CropBatch, MotionConfiguration, MotionNetwork
from avsec_gym.rig import KITTI_CAMERAS, camera_rig

RIG = camera_rig(KITTI_CAMERAS, focal_length=360.0, centre=(310.0, 86.3), size=(621, 187))
"""KITTI's at half its resolution."""
CALIBRATION = RIG.calibration
WIDTH, HEIGHT = RIG.size
GROUND, CEILING = 1.65, -8.0
"""y of two textured planes, camera frame."""


def texture(x: Floats, z: Floats) -> Floats:
    """Grey levels of a plane at x, z metres: smooth noise at several scales, nowhere alike."""
    levels = 128.0 * np.ones_like(x)
    rng = np.random.default_rng(0)
    for size, strength in ((0.4, 30.0), (1.0, 30.0), (2.5, 30.0)):
        lattice = rng.standard_normal((256, 256))
        u, v = x / size % 255, z / size % 255
        i, j = u.astype(int), v.astype(int)
        a, b = u - i, v - j
        levels += strength * (
            (1 - a) * ((1 - b) * lattice[i, j] + b * lattice[i, j + 1])
            + a * ((1 - b) * lattice[i + 1, j] + b * lattice[i + 1, j + 1])
        )
    return np.clip(levels, 0, 255)


def photograph(
    camera: int, motion: Floats | None = None, box: Boxes3D | None = None, mark: float = 250.0
) -> Image:
    """Two planes, above and below, and a box with a bright face, as a camera sees them.

    ``motion`` takes places in the present camera frame to that of the picture.
    """
    motion = np.eye(4) if motion is None else motion
    projection = CALIBRATION.projection(camera)
    u, v = np.meshgrid(np.arange(WIDTH, dtype=float), np.arange(HEIGHT, dtype=float))
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(projection[:, :3]).T
    back = np.linalg.inv(motion)
    eye = transform_points(back, CALIBRATION.camera_centre(camera))
    rays = rays @ back[:3, :3].T
    with np.errstate(divide="ignore"):
        depth = np.where(rays[..., 1] > 0, GROUND - eye[1], CEILING - eye[1]) / rays[..., 1]
    places = eye + rays * np.minimum(depth, 400.0)[..., None]
    image = np.where(depth < 120.0, texture(places[..., 0], places[..., 2]), 128.0)
    if box is not None:
        height, width, length = box.dimensions[0]
        assert box.rotation_y[0] == -np.pi / 2, "the near face looks at the camera"
        near = box.location[0, 2] - length / 2
        at = eye + rays * ((near - eye[2]) / rays[..., 2])[..., None]
        inside = np.abs(at[..., 0] - box.location[0, 0]) < width / 2
        inside &= (at[..., 1] < box.location[0, 1]) & (at[..., 1] > box.location[0, 1] - height)
        image = np.where(inside, mark - 100 * (np.floor(4 * at[..., 0]) % 2), image)
    return np.repeat(image.round().astype(np.uint8)[..., None], 3, axis=2)


def moved(forward: float, right: float = 0.0, yaw: float = 0.0) -> Floats:
    """From the present camera frame to an earlier one, before the car drove and turned so."""
    motion = np.eye(4)
    cos, sin = np.cos(yaw), np.sin(yaw)
    motion[:3, :3] = [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]
    motion[:3, 3] = [right, 0.0, forward]
    return motion


def one_car(x: float, z: float) -> Boxes3D:
    return Boxes3D(
        location=np.array([[x, GROUND, z]]),
        dimensions=np.array([[1.5, 1.7, 4.0]]),
        rotation_y=np.array([-np.pi / 2]),
        score=np.ones(1),
        category=np.array(["Car"]),
    )


def scene(motion: Floats, *boxes: Boxes3D) -> SensorFrame:
    """The present with the first box, and a frame before with the second."""
    now, before = boxes or (None, None)
    earlier = SensorFrame("0_01", CALIBRATION, {2: photograph(2, motion, before)})
    images = {camera: photograph(camera, None, now) for camera in (2, 3)}
    return SensorFrame("0", CALIBRATION, images, previous=(earlier,))


@pytest.mark.parametrize(
    "motion", [moved(0.0), moved(1.2), moved(0.8, 0.05, 0.02), moved(1.0, -0.1, -0.01)]
)
def test_ego_motion_is_found_to_a_decimetre_and_a_few_milliradians(motion: Floats) -> None:
    frame = scene(motion)
    found = ego_motion(frame, frame.previous[0])
    assert found is not None
    assert np.abs(found[:3, 3] - motion[:3, 3]).max() < 0.1
    assert np.abs(found[:3, :3] - motion[:3, :3]).max() < 2.5e-3


def test_ego_motion_is_not_guessed() -> None:
    frame = scene(moved(1.0))
    grey = np.full((HEIGHT, WIDTH, 3), 90, np.uint8)
    noise = np.random.default_rng(1).integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)
    for image in (grey, noise):
        assert ego_motion(frame, SensorFrame("1", CALIBRATION, {2: image})) is None
    assert ego_motion(replace(frame, images={2: frame.image(2)}), frame.previous[0]) is None
    everywhere = np.array([[0.0, 0.0, WIDTH, HEIGHT]])
    assert ego_motion(frame, frame.previous[0], everywhere) is None


def test_crops_of_what_stands_agree_and_of_what_moves_do_not() -> None:
    motion, here = moved(1.0, 0.03, 0.01), one_car(-2.5, 14.0)
    difference = {}
    for name, before in (("stands", here), ("moves", one_car(-2.5, 13.0))):
        frame = scene(motion, here, before)
        projection = CALIBRATION.projection(2)
        regions = object_regions(here, projection, (HEIGHT, WIDTH))
        now = current_crops(frame.image(2), regions, (64, 64)).astype(float)
        then = earlier_crops(
            frame.previous[0].image(2), regions, (64, 64), here, projection, motion
        ).astype(float)
        middle = np.s_[0, 14:50, 14:50]
        difference[name] = np.abs(now - then)[middle].mean()
        if name == "stands":
            assert np.abs(now - then)[0, 58:].mean() < 8.0, "the ground is where it was"
    assert difference["stands"] < 8.0
    assert difference["moves"] > 4 * difference["stands"]


@pytest.mark.parametrize("way", [2.5, 0.6, -1.5])
def test_the_way_that_an_object_drove_is_found(way: float) -> None:
    motion, here = moved(1.2), one_car(-2.5, 14.0)
    frame = scene(motion, here, one_car(-2.5, 14.0 - way))
    projection, now, before = CALIBRATION.projection(2), frame.image(2), frame.previous[0].image(2)
    regions = object_regions(here, projection, (HEIGHT, WIDTH))
    found = likeliest_ways(now, before, regions, here, projection, motion)
    assert found == pytest.approx([way], abs=0.15 + 0.1 * abs(way))
    # Told so, the earlier crop is the current one again.
    current, drove, stood = (
        crops[0, 16:48, 16:48].astype(float)
        for crops in (
            current_crops(now, regions, (64, 64)),
            earlier_crops(before, regions, (64, 64), here, projection, motion, found),
            earlier_crops(before, regions, (64, 64), here, projection, motion),
        )
    )
    assert np.abs(drove - current).mean() < 0.7 * np.abs(stood - current).mean()


def test_who_stood_has_driven_the_least_way_there_is() -> None:
    motion, here = moved(1.2), one_car(-2.5, 14.0)
    frame = scene(motion, here, here)
    projection = CALIBRATION.projection(2)
    regions = object_regions(here, projection, (HEIGHT, WIDTH))
    images = frame.image(2), frame.previous[0].image(2)
    assert np.abs(likeliest_ways(*images, regions, here, projection, motion)) < 2 * LEAST


def test_a_crop_shows_its_region_and_black_beyond_the_image() -> None:
    u, v = np.meshgrid(np.arange(200.0), np.arange(100.0))
    image = np.stack([u, v, np.full_like(u, 77.0)], axis=-1).astype(np.uint8)
    regions = np.array([[40.0, 20.0, 72.0, 36.0], [-50.0, 20.0, 50.0, 60.0]])
    exact, beyond = current_crops(image, regions, (16, 32))
    # A pixel of the crop is a pixel of the image, half a pixel from the region's side.
    assert np.abs(exact[:, :, 0] - np.arange(40.5, 72.0)).max() <= 1
    assert np.abs(exact[:, :, 1] - np.arange(20.5, 36.0)[:, None]).max() <= 1
    assert (beyond[:, :15] == 0).all()
    assert (beyond[:, 17:, 2] == 77).all()


def test_regions_hold_the_box_with_context_and_never_vanish() -> None:
    boxes = Boxes3D.concatenate([one_car(0.0, 20.0), one_car(3.0, 900.0), one_car(0.5, 1.0)])
    projection = CALIBRATION.projection(2)
    regions = object_regions(boxes, projection, (HEIGHT, WIDTH), context=1.5)
    pixels, _ = project(projection, boxes.location[0] - [0.0, 0.75, 2.0])
    assert np.isfinite(regions).all()
    assert ((regions[:, 2:] - regions[:, :2]) >= 6.0 - 1e-9).all()
    assert (regions[0, :2] < pixels).all()
    assert (pixels < regions[0, 2:]).all()
    given = replace(one_car(0.0, 20.0), box2d=np.array([[100.0, 100.0, 200.0, 150.0]]))
    assert np.allclose(
        object_regions(given, projection, (HEIGHT, WIDTH), 1.4), [[80.0, 90.0, 220.0, 160.0]]
    )


def test_vgg16_has_the_body_of_the_published_one_and_one_output() -> None:
    network = MotionNetwork(MotionConfiguration.preset("vgg16"))
    body = {k: tuple(v.shape) for k, v in network.features.state_dict().items()}
    assert sum(int(np.prod(shape)) for shape in body.values()) == 14_714_688
    # Places of the convolutions in common checkpoints of VGG-16.
    places = [0, 2, 5, 7, 10, 12, 14, 17, 19, 21, 24, 26, 28]
    assert sorted({int(key.split(".")[0]) for key in body}) == places
    assert body["28.weight"] == (512, 512, 3, 3)
    assert network.classifier[-1].out_features == 1
    assert network.classifier[2].in_features == 512 * 7 * 7


@pytest.mark.parametrize("neighbour", [True, False])
def test_network_sees_the_neighbour_where_it_is_known_and_only_there(neighbour: bool) -> None:
    torch.manual_seed(0)
    small = MotionConfiguration.preset("small")
    network = MotionNetwork(replace(small, neighbour=neighbour)).double().eval()
    now = torch.rand(4, 3, *small.crop, dtype=torch.float64) * 255
    one, other = torch.rand(2, 4, 2, 3, *small.crop, dtype=torch.float64) * 255
    for known in (True, False):
        mask = torch.full((4,), known)
        answers = [network(CropBatch(now, before, mask)) for before in (one, other)]
        assert torch.equal(*answers) == (not (neighbour and known))
        assert answers[0].shape == (4,)


def test_classifies_with_and_without_earlier_frames() -> None:
    torch.manual_seed(0)
    classifier = MovingObjectClassifier(weights=None)
    here = one_car(-2.5, 14.0)
    boxes = Boxes3D.concatenate([here, one_car(3.0, 30.0)])
    frame = scene(moved(1.0), here, here)
    crops = classifier.crops(boxes, frame)
    assert crops.before is not None
    assert classifier.crops(boxes, replace(frame, previous=())).before is None
    blind = SensorFrame("x", CALIBRATION, {2: np.zeros((HEIGHT, WIDTH, 3), np.uint8)})
    assert neighbour_of(replace(frame, previous=(blind,)), boxes) is None
    assert neighbour_of(replace(frame, previous=(blind, frame.previous[0])), boxes) is not None
    for seen in (frame, replace(frame, previous=()), replace(frame, images={2: frame.image(2)})):
        found = classifier.classify(boxes, seen)
        probabilities = classifier.probabilities(boxes, seen)
        assert ((probabilities > 0) & (probabilities < 1)).all()
        assert found.moving is not None
        np.testing.assert_array_equal(found.location, boxes.location)
    nothing = classifier.classify(Boxes3D.empty(), frame)
    assert nothing.moving is not None
    assert nothing.moving.shape == (0,)
    with pytest.raises(DataError, match="camera 2"):
        classifier.classify(boxes, replace(frame, images={}))


@pytest.mark.parametrize(
    ("preset", "earlier", "moves"),
    [("small", True, True), ("small", False, False), ("vgg16", False, True)],
)
def test_abstains_where_it_could_compare_and_cannot(
    preset: str, earlier: bool, moves: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = one_car(-2.5, 14.0)
    frame = scene(moved(1.0), here, here)
    configuration = replace(MotionConfiguration.preset(preset), stages=((4,),), hidden=2)
    classifier = MovingObjectClassifier(configuration, weights=None)
    monkeypatch.setattr(classifier, "probabilities_of", lambda crops: np.array([0.7]))
    found = classifier.classify(here, frame if earlier else replace(frame, previous=()))
    assert found.moving is not None
    assert found.moving.tolist() == [moves]


def test_refuses_what_cannot_be() -> None:
    with pytest.raises(ConfigurationError, match="known: vgg16, small"):
        MovingObjectClassifier("large")
    with pytest.raises(ConfigurationError, match="another network"):
        MovingObjectClassifier(weights={})
    small = MotionConfiguration.preset("small")
    for wrong in ({"stages": ((8,),) * 7}, {"stages": ()}, {"dropout": 1.0}, {"hidden": 0}):
        with pytest.raises(ConfigurationError):
            replace(small, **wrong)


def test_shipped_weights_think_a_car_that_drove_likelier_to_move() -> None:
    classifier = MovingObjectClassifier()
    here = one_car(-2.5, 14.0)
    probability = [
        classifier.probabilities(here, scene(moved(1.5), here, before))[0]
        for before in (here, one_car(-2.5, 11.5))
    ]
    assert probability[0] + 0.1 < probability[1]


@pytest.mark.slow
def test_shipped_weights_on_a_real_street(shared: Path) -> None:
    data = KittiObject(shared / "kitti" / "object")
    boxes, frame = data.labels("000274"), data.frame("000274")
    probability = MovingObjectClassifier().probabilities(boxes, frame)
    x, z = boxes.location[:, 0], boxes.location[:, 2]
    cars = boxes.category == "Car"
    # By stereo, points on the car ahead came 2.3 m nearer in 0.3 s than they would had it stood.
    ahead = cars & (np.abs(x) < 1) & (z < 20)
    parked = cars & (x > -5.5) & (x < -4) & (z < 30)
    assert (ahead.sum(), parked.sum()) == (1, 3)
    assert probability[ahead] > 0.5
    assert (probability[parked] < 0.5).all()
