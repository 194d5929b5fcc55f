"""The learned estimator's borders: sizes, units, gradients."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.depth.psmnet import PsmNetConfiguration
from avsec_gym.perception.depth.psmnet_depth import PsmNetDepth
from avsec_gym.perception.nn.pyramid_pooling import FeatureConfiguration
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.rig import kitti_rig


def estimator(input_size: tuple[int, int] | None) -> PsmNetDepth:
    features = FeatureConfiguration(
        first=8, stages=((8, 1),) * 4, windows=((8, 8), (4, 4)), pooled=4, matching=(8, 8)
    )
    torch.manual_seed(0)
    return PsmNetDepth(PsmNetConfiguration(input_size, 32, features, 8))


def batch(height: int, width: int) -> StereoBatch:
    rng = np.random.default_rng(0)
    images = {i: rng.integers(0, 256, (height, width, 3), np.uint8) for i in (2, 3)}
    return batch_of_frames([SensorFrame("000000", kitti_rig().calibration, images)])


def test_disparities_are_in_the_pixels_of_the_image() -> None:
    one = batch(64, 128)
    own, reduced = estimator(None), estimator((32, 64))
    reduced.network.load_state_dict(own.network.state_dict())
    small = own.disparity_batch(one.resized(32, 64))
    found = reduced.disparity_batch(one)
    assert found.shape == (1, 64, 128)
    assert float(found.mean()) == pytest.approx(2 * float(small.mean()), rel=1e-3)


def test_any_image_size_is_padded_at_the_top_and_the_right() -> None:
    one = batch(53, 119)
    found = estimator(None).disparity_batch(one)
    assert found.shape == (1, 53, 119)
    frame_map = estimator(None).disparity(
        SensorFrame("0", kitti_rig().calibration, {
            camera: image[0].permute(1, 2, 0).byte().numpy()
            for camera, image in ((2, one.left), (3, one.right))
        })
    )  # fmt: skip
    np.testing.assert_allclose(frame_map.values, found[0].numpy(), atol=1e-4)


def test_loss_is_zero_for_its_own_answer_and_reaches_every_pixel() -> None:
    depth = estimator((32, 64))
    one = batch(64, 128)
    one.left.requires_grad_(True)
    one.right.requires_grad_(True)
    own = depth.disparity_batch(one.resized(32, 64)) * 2
    own = own.repeat_interleave(2, 1).repeat_interleave(2, 2)
    assert float(depth.losses(one, own)["disparity"].detach()) == pytest.approx(0, abs=1e-8)
    loss = depth.losses(one, torch.full((1, 64, 128), 20.0))["disparity"]
    left, right = torch.autograd.grad(loss, [one.left, one.right])
    for gradient in (left, right):
        assert (gradient.abs().sum(1) > 0).double().mean() >= 0.99


def test_unknown_presets_and_foreign_weights_are_refused() -> None:
    with pytest.raises(ConfigurationError, match=r"no PSMNet is called 'tiny'"):
        PsmNetDepth("tiny")
    with pytest.raises(ConfigurationError, match=r"weights of another network"):
        PsmNetDepth("full", weights={"x": torch.zeros(1)})


def test_medium_is_small_on_larger_images_with_its_weights() -> None:
    small, medium = (PsmNetDepth(name, "shipped").network for name in ("small", "medium"))
    ours, others = small.state_dict(), medium.state_dict()
    assert ours.keys() == others.keys()
    assert all(torch.equal(values, others[name]) for name, values in ours.items())
    least, larger = (PsmNetConfiguration.preset(name) for name in ("small", "medium"))
    assert least.input_size is not None
    assert larger.input_size is not None
    assert larger.input_size > least.input_size
    # As near as the small one sees, in the camera's pixels.
    assert larger.disparities / larger.input_size[1] >= least.disparities / least.input_size[1]
