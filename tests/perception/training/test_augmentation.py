"""Varied samples are still true: objects are seen where projections and disparities say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, box_corners, project
from avsec_gym.perception.training.augmentation import augmented
from avsec_gym.perception.training.configuration import Augmentation, Photometric
from avsec_gym.perception.training.photometric import relit
from avsec_gym.perception.training.sample import StereoSample, sample_batch
from avsec_gym.perception.training.stereo_flip import flipped
from avsec_gym.perception.training.zoom import zoomed

MakeSample = Callable[..., StereoSample]
SpotErrors = Callable[[StereoSample], Floats]
UNLIT = Photometric(0, 0, 0, 0, 0, 0, 0)


def disparity_at_object(sample: StereoSample) -> tuple[float, float]:
    """What the left map says at the object, and what follows from the projections."""
    places = [
        project(projection, sample.truth.location)[0][0]
        for projection in (sample.left_projection, sample.right_projection)
    ]
    column, row = np.round(places[0]).astype(int)
    return float(sample.left_disparity[row, column]), float(places[0][0] - places[1][0])


@pytest.mark.parametrize("x", [-3.0, 0.0, 2.5])
def test_mirrored_pair_is_a_true_pair(
    spot_sample: MakeSample, spot_errors: SpotErrors, x: float
) -> None:
    sample = spot_sample(x=x)
    other = flipped(sample)
    assert spot_errors(sample).max() < 0.05
    assert spot_errors(other).max() < 0.05
    found, expected = disparity_at_object(other)
    assert found == pytest.approx(expected, abs=0.05)
    assert found > 5
    # The left camera stays where it was, and so does the distance between the two.
    for one, two in ((sample, other),):
        centres = [
            [
                -np.linalg.solve(matrix[:, :3], matrix[:, 3])[0]
                for matrix in (s.left_projection, s.right_projection)
            ]
            for s in (one, two)
        ]
        np.testing.assert_allclose(centres[0], centres[1], atol=1e-9)


def test_mirrored_box_covers_the_mirrored_object(spot_sample: MakeSample) -> None:
    sample = spot_sample(x=-1.0, rotation_y=0.4)
    other = flipped(sample)
    truth = other.truth
    corners = box_corners(truth.location, truth.dimensions, truth.rotation_y)[0]
    uv, _ = project(other.left_projection, corners)
    assert truth.box2d is not None
    np.testing.assert_allclose(truth.box2d[0], [*uv.min(0), *uv.max(0)], atol=0.6)
    assert truth.alpha is not None
    assert sample.truth.alpha is not None
    assert truth.alpha[0] == pytest.approx(np.pi - sample.truth.alpha[0])


def test_mirrored_twice_is_as_before(spot_sample: MakeSample) -> None:
    sample = spot_sample()
    again = flipped(flipped(sample))
    np.testing.assert_array_equal(again.left, sample.left)
    np.testing.assert_array_equal(again.right_disparity, sample.right_disparity)
    np.testing.assert_allclose(again.left_projection, sample.left_projection, atol=1e-9)
    np.testing.assert_allclose(again.truth.location, sample.truth.location, atol=1e-9)
    np.testing.assert_allclose(again.truth.rotation_y, sample.truth.rotation_y, atol=1e-9)


@pytest.mark.parametrize(("left", "top"), [(0.0, 0.0), (0.3, 0.9), (1.0, 1.0)])
def test_enlarged_pair_is_a_true_pair(
    spot_sample: MakeSample, spot_errors: SpotErrors, left: float, top: float
) -> None:
    sample = spot_sample(x=-0.5)
    other = zoomed(sample, 1.3, left, top)
    # Interpolation between pixels is counted in steps of 1/32 by OpenCV.
    assert spot_errors(other).max() < 0.1
    found, expected = disparity_at_object(other)
    assert found == pytest.approx(expected, abs=0.05)
    assert expected == pytest.approx(1.3 * disparity_at_object(sample)[1])
    assert other.left_projection[0, 0] == pytest.approx(1.3 * sample.left_projection[0, 0])


def test_objects_out_of_the_window_are_left_out_and_cut_ones_truncated(
    spot_sample: MakeSample,
) -> None:
    at_the_left = spot_sample(x=-9.0)
    assert len(zoomed(at_the_left, 1.5, 1.0, 0.5).truth) == 0
    sample = spot_sample(x=-4.0)
    assert sample.truth.box2d is not None
    middle = float(sample.truth.box2d[0, [0, 2]].mean())
    # The window begins in the object's middle.
    window = zoomed(sample, 2.0, middle / (sample.size[1] / 2), 0.5).truth
    assert window.truncation is not None
    assert window.truncation[0] == pytest.approx(0.5, abs=0.05)
    assert window.box2d is not None
    assert window.box2d[0, 0] == 0


def test_light_changes_grey_levels_only_and_stays_in_range(spot_sample: MakeSample) -> None:
    sample = spot_sample()
    rng = np.random.default_rng(0)
    np.testing.assert_allclose(relit(sample, UNLIT, rng).left, sample.left, atol=1e-3)
    other = relit(sample, Photometric(), rng)
    assert other.left.dtype == np.uint8
    assert 0 <= other.left.min() < other.left.max() <= 255
    assert np.abs(other.left - sample.left.astype(float)).mean() > 1
    assert other.left_disparity is sample.left_disparity
    equal = relit(sample, Photometric(noise=0, between_views=0), rng)
    unequal = relit(sample, Photometric(noise=0, between_views=1), rng)

    def background(image: np.ndarray) -> float:
        return float(np.median(image))

    assert background(equal.left) == pytest.approx(background(equal.right), abs=1e-3)
    assert abs(background(unequal.left) - background(unequal.right)) > 0.1


def test_noise_has_the_spread_that_is_asked_for(spot_sample: MakeSample) -> None:
    sample = spot_sample()
    spreads = [
        (relit(sample, Photometric(0, 0, 0, 0, 0, 0, noise=6), np.random.default_rng(i)).left
         - sample.left.astype(float)).std()
        for i in range(40)
    ]  # fmt: skip
    assert sum(spread > 0 for spread in spreads) > 35  # the weakest are rounded away
    assert 2.0 < np.mean(spreads) < 4.0
    assert max(spreads) < 6.2


def test_same_randomness_same_sample_and_half_of_them_mirrored(spot_sample: MakeSample) -> None:
    sample = spot_sample(x=3.0)
    settings = Augmentation()
    one, two, three = (
        augmented(sample, settings, np.random.default_rng(seed)) for seed in (5, 5, 6)
    )
    np.testing.assert_array_equal(one.left, two.left)
    assert not np.array_equal(one.left, three.left)
    rng = np.random.default_rng(1)
    sides = [augmented(sample, settings, rng).truth.location[0, 0] > 0 for _ in range(60)]
    assert 15 < sum(sides) < 45


def test_batch_of_samples_keeps_geometry(spot_sample: MakeSample) -> None:
    samples = [spot_sample(), flipped(spot_sample(x=-1.0))]
    batch = sample_batch(samples)
    assert batch.stereo.left.shape == (2, 3, 120, 400)
    assert batch.disparity.shape == (2, 120, 400)
    assert batch.stereo.size == (120, 400)
    np.testing.assert_allclose(batch.stereo.baseline.numpy(), 126 / 240, rtol=1e-12)


def test_some_samples_are_those_of_grey_cameras(spot_sample: MakeSample) -> None:
    coloured = np.random.default_rng(0).integers(0, 256, spot_sample().left.shape, np.uint8)
    sample = replace(spot_sample(), left=coloured, right=coloured)
    limits = replace(UNLIT, grey=0.5)
    found = [relit(sample, limits, np.random.default_rng(seed)).left for seed in range(40)]
    mean = coloured.mean(axis=2, keepdims=True)
    is_grey = [np.ptp(image, axis=2).max() == 0 for image in found]
    assert 10 <= sum(is_grey) <= 30
    for image, grey in zip(found, is_grey, strict=True):
        expected = np.broadcast_to(np.rint(mean), image.shape) if grey else coloured
        np.testing.assert_array_equal(image, expected)
    # However tinted and noisy: all three channels are one.
    lit = relit(sample, Photometric(grey=1.0), np.random.default_rng(0))
    assert max(np.ptp(image, axis=2).max() for image in (lit.left, lit.right)) < 1e-3
    with pytest.raises(ConfigurationError):
        Photometric(grey=1.5)
