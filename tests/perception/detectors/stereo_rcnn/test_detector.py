"""The detector as a whole, on a narrow network and painted pairs of images."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import box_corners, project
from avsec_gym.perception.detectors.detector import DifferentiableDetector
from avsec_gym.perception.detectors.stereo_rcnn.alignment import Alignment
from avsec_gym.perception.detectors.stereo_rcnn.configuration import SMALL, ProposalCount
from avsec_gym.perception.detectors.stereo_rcnn.decoding_rule import StereoRcnnDecodingRule
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.detectors.stereo_rcnn.losses import FIT, TERMS
from avsec_gym.perception.nn.region_counts import SampleCount
from avsec_gym.perception.stereo_batch import batch_of_frames

NARROW = replace(
    SMALL,
    input_size=(96, 320),
    stem_channels=16,
    stage_blocks=(1, 1, 1, 1),
    stage_channels=(8, 16, 16, 16),
    pyramid_channels=32,
    rpn_channels=32,
    box_channels=64,
    keypoint_channels=32,
    keypoint_convolutions=1,
    anchor_sizes=(8, 16, 32, 64, 128),
    training_proposals=ProposalCount(300, 60),
    test_proposals=ProposalCount(100, 20),
)
SAMPLE = SampleCount(anchors=64, regions=24)
LEFT = np.array([[360.0, 0, 320, 20], [0, 360, 90, 0], [0, 0, 1, 0]])
RIGHT = np.array([[360.0, 0, 320, -172], [0, 360, 90, 0], [0, 0, 1, 0]])
LABELS = Boxes3D(
    [[-3.0, 1.6, 10], [3, 1.65, 14]],
    [[1.5, 1.6, 4.0], [1.4, 1.7, 4.2]],
    [-1.2, 0.4],
    np.ones(2),
    np.full(2, "Car"),
    truncation=np.zeros(2),
    occlusion=np.zeros(2),
)


def frame(labels=LABELS, seed=0):
    """Red and blue cars in front of grey, with noise, 192 x 640 pixels."""
    random = np.random.default_rng(seed)
    images = {}
    for camera, projection in ((2, LEFT), (3, RIGHT)):
        # Noise everywhere: where colours are exactly equal, maxima have no derivative.
        image = random.integers(60, 120, (192, 640, 3))
        for i, corners in enumerate(
            box_corners(labels.location, labels.dimensions, labels.rotation_y)
        ):
            pixels, _ = project(projection, corners)
            (u1, v1), (u2, v2) = pixels.min(axis=0).astype(int), pixels.max(axis=0).astype(int)
            image[max(v1, 0) : v2, max(u1, 0) : u2] += [[120, 0, -40], [-40, 0, 120]][i % 2]
        images[camera] = image.astype(np.uint8)
    projections = np.stack([LEFT, LEFT, LEFT, RIGHT])
    return SensorFrame("0", Calibration(projections, np.eye(3), np.eye(4)[:3]), images)


@pytest.fixture
def detector():
    torch.manual_seed(0)
    return StereoRcnnDetector(NARROW, sample=SAMPLE)


def pixels(batch, dtype=torch.float32):
    return replace(
        batch,
        left=batch.left.to(dtype).requires_grad_(),
        right=batch.right.to(dtype).requires_grad_(),
    )


def test_it_is_a_frozen_differentiable_detector(detector):
    assert isinstance(detector, DifferentiableDetector)
    assert detector.name == "stereo_rcnn"
    assert not detector.network.training
    assert not any(weight.requires_grad for weight in detector.network.parameters())
    with pytest.raises(ConfigurationError, match="tiny"):
        StereoRcnnDetector("tiny")
    with pytest.raises(ConfigurationError, match="another network"):
        StereoRcnnDetector(NARROW, weights={})


def test_weights_are_taken(detector):
    copy = StereoRcnnDetector(NARROW, weights=detector.network.state_dict())
    one, two = detector.detect(frame()), copy.detect(frame())
    np.testing.assert_array_equal(one.score, two.score)


def test_detections_are_kitti_s(detector):
    boxes = detector.detect(frame())
    assert boxes.box2d is not None
    assert boxes.alpha is not None
    assert set(boxes.category) <= {"Car"}
    assert (np.diff(boxes.score) <= 0).all()
    assert (boxes.box2d >= 0).all()
    assert (boxes.box2d <= [639, 191, 639, 191]).all()
    assert (boxes.location[:, 2] > 0).all()


def test_a_batch_is_its_frames(detector):
    frames = [frame(seed=1), frame(LABELS[:1], seed=2)]
    together = detector.detect_batch(batch_of_frames(frames))
    for pair, boxes in zip(frames, together, strict=True):
        alone = detector.detect(pair)
        np.testing.assert_allclose(boxes.score, alone.score, rtol=1e-4)
        np.testing.assert_allclose(boxes.box2d, alone.box2d, atol=0.05)


def test_nothing_likely_is_nothing_found(detector):
    detector.rule = replace(detector.rule, least_score=1.0)
    assert len(detector.detect(frame())) == 0


def test_boxes_stay_in_camera_pixels(detector):
    batch = batch_of_frames([frame()])
    whole, half = (detector.detect_batch(images)[0] for images in (batch, batch.resized(96, 320)))
    assert half.box2d[:, 2].max() > 330
    assert len(whole)


def test_the_published_input():
    detector = StereoRcnnDetector(replace(NARROW, input_size=None, blue_first=True, mean=(1, 2, 3)))
    batch = batch_of_frames([frame()])
    batch.left[:] = torch.tensor([30.0, 20, 10])[:, None, None]
    left, right = detector.prepare(batch)
    assert left.shape == right.shape == (1, 3, 600, 2000)
    expected = torch.tensor([9 / 70, 18 / 70, 27 / 70])
    torch.testing.assert_close(left[0, :, 300, 900], expected)


def test_the_gradient_reaches_every_pixel(detector):
    batch = pixels(batch_of_frames([frame()]))
    terms = detector.losses(batch, [LABELS])
    assert tuple(terms) == (*TERMS, FIT)
    sum(terms.values()).backward()
    for image in (batch.left, batch.right):
        assert (image.grad != 0).any(dim=1).float().mean() >= 0.99
    for weight in detector.network.parameters():
        assert weight.grad is None


def test_losses_repeat_outside_of_training(detector):
    batch = batch_of_frames([frame()])
    first, second = (sum(detector.losses(batch, [LABELS]).values()) for _ in range(2))
    assert first == second
    frozen = detector.losses(batch, [LABELS], sampling=detector.draw(batch, [LABELS]))
    assert sum(frozen.values()) == first
    detector.network.train()
    one, two = (detector.draw(batch, [LABELS]).anchor_labels for _ in range(2))
    assert not torch.equal(one, two)


def test_fit_is_a_term_where_the_configuration_has_it():
    torch.manual_seed(0)
    plain = StereoRcnnDetector(
        replace(NARROW, fit=False, rule=StereoRcnnDecodingRule()), sample=SAMPLE
    )
    batch = batch_of_frames([frame()])
    assert tuple(plain.losses(batch, [LABELS])) == TERMS
    assert plain.draw(batch, [LABELS]).fit_targets is None


def test_an_empty_street_has_a_loss(detector):
    batch = pixels(batch_of_frames([frame(LABELS[:0])]))
    sum(detector.losses(batch, [Boxes3D.empty()]).values()).backward()
    assert torch.isfinite(batch.left.grad).all()


@pytest.mark.usefixtures("smooth_activations")
def test_directional_derivatives_agree_with_finite_differences(detector):
    detector.network.double()
    detector.term_weights.double()
    batch = pixels(batch_of_frames([frame()]), torch.float64)
    sampling = detector.draw(batch, [LABELS])

    def loss(left, right):
        moved = replace(batch, left=left, right=right)
        return sum(detector.losses(moved, [LABELS], sampling=sampling).values())

    loss(batch.left, batch.right).backward()
    generator = torch.Generator().manual_seed(0)
    for _ in range(3):
        ways = [torch.randn(batch.left.shape, generator=generator).double() for _ in range(2)]
        slope = (ways[0] * batch.left.grad).sum() + (ways[1] * batch.right.grad).sum()
        with torch.no_grad():
            ahead, behind = (
                loss(batch.left + step * ways[0], batch.right + step * ways[1])
                for step in (1e-5, -1e-5)
            )
        assert float((ahead - behind) / 2e-5) == pytest.approx(float(slope), rel=1e-4)


@pytest.fixture
def one_thread():
    """The last digits, and with them what a training comes to, depend on the number of threads."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.mark.slow
def test_one_picture_can_be_learned_by_heart(detector, one_thread):
    detector.alignment = Alignment(coarse_steps=1, fine_steps=1, disparity_offset=0)
    # Both cars are seen at an angle. With one of them nearly straight from behind, which corner is
    # the nearest was learned last, and by three of four seeds not in time: 4 m of depth hang on it.
    labels = replace(LABELS, rotation_y=np.array([-1.2, 0.9]))
    batch = batch_of_frames([frame(labels)])
    weights = [*detector.network.parameters(), *detector.term_weights.parameters()]
    for weight in weights:
        weight.requires_grad_(True)
    detector.network.train()
    steps = 300
    optimiser = torch.optim.AdamW(weights, 2e-3)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, 2e-3, steps)
    for _ in range(steps):
        optimiser.zero_grad()
        sum(detector.losses(batch, [labels]).values()).backward()
        torch.nn.utils.clip_grad_norm_(weights, 10)
        optimiser.step()
        schedule.step()
    detector.network.eval()
    found = detector.detect(frame(labels))[:2]
    assert (found.score > 0.25).all()
    for location, size in zip(labels.location, labels.dimensions, strict=True):
        nearest = np.linalg.norm(found.location - location, axis=1).argmin()
        error = np.abs(found.location[nearest] - location)
        assert (error < [0.4, 0.2, 0.1 * location[2]]).all()
        np.testing.assert_allclose(found.dimensions[nearest], size, atol=0.15)
