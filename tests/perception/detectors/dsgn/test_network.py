"""DSGN's network: keys, shapes, geometry, gradients."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from avsec_gym.geometry import box_corners, project
from avsec_gym.perception.detectors.dsgn.box_field import BoxField
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.grid import CAR, CYCLIST
from avsec_gym.perception.detectors.dsgn.network import DsgnNetwork

_PROJECTION = torch.tensor(
    [[110.0, 0.0, 96.0, 6.0], [0.0, 110.0, 25.0, 0.1], [0.0, 0.0, 1.0, 0.003]], dtype=torch.float64
)


def _inputs(size, batch=1, dtype=torch.float32):
    generator = torch.Generator().manual_seed(0)
    left, right = torch.randn(2, batch, 3, *size, generator=generator, dtype=dtype)
    shift = torch.full((batch,), 110 * 0.54, dtype=torch.float64)
    return left, right, _PROJECTION.expand(batch, 3, 4), shift


def _network(configuration):
    torch.manual_seed(0)
    return DsgnNetwork(configuration).eval()


@pytest.mark.parametrize(
    ("preset", "keys", "parameters"),
    [("default", "config_car", 17_262_958), ("12g", "config_car_12g", 8_054_422)],
)
def test_keys_are_the_originals(shared, preset, keys, parameters):
    lines = (shared / "parity" / f"{keys}_keys.txt").read_text().splitlines()
    with torch.device("meta"):
        network = DsgnNetwork(DsgnConfiguration.preset(preset))
    ours = [f"{key} {tuple(value.shape)}" for key, value in network.state_dict().items()]
    assert sorted(ours) == sorted(lines)
    assert sum(parameter.numel() for parameter in network.parameters()) == parameters


def test_the_24g_preset_has_the_originals_size():
    with torch.device("meta"):
        network = DsgnNetwork(DsgnConfiguration.preset("24g"))
    assert sum(parameter.numel() for parameter in network.parameters()) == 14_043_710


@pytest.mark.parametrize("full_depth", [True, False])
def test_shapes(tiny, full_depth):
    configuration = replace(tiny, full_depth=full_depth, anchors=(CAR, CYCLIST))
    height, width = configuration.padded_size
    with torch.no_grad():
        output = _network(configuration)(*_inputs((height, width), batch=2))
    cells = (configuration.grid.z.cells, configuration.grid.x.cells)
    scale = 1 if full_depth else 4
    bins = configuration.bins.count
    assert output.depth.shape == (2, height, width)
    assert output.depth_logits.shape == (2, bins, height // scale, width // scale)
    assert output.class_logits.shape == (2, 4, 2, *cells)
    assert output.corners.shape == (2, 4, 2, 8, 3, *cells)
    assert output.centerness.shape == (2, 4, *cells)
    assert output.depth_bins.tolist() == pytest.approx(configuration.bins.values().tolist())
    assert configuration.bins.near <= output.depth.min()
    assert output.depth.max() <= configuration.bins.far


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_gradient_reaches_nearly_every_pixel_of_both_images(tiny, dtype):
    network = _network(tiny).to(dtype)
    left, right, projection, shift = _inputs(tiny.padded_size, dtype=dtype)
    output = network(left.requires_grad_(), right.requires_grad_(), projection, shift)
    assert output.corners.dtype == output.depth.dtype == dtype
    (output.corners.square().mean() + output.class_logits.square().mean()).backward()
    for image in (left, right):
        assert (image.grad.abs().sum(1) > 0).float().mean() > 0.99


@pytest.mark.usefixtures("smooth_activations")
def test_gradient_agrees_with_finite_differences(tiny):
    network = _network(replace(tiny, exact_pixels=True)).double()
    left, right, projection, shift = _inputs(tiny.padded_size, dtype=torch.float64)

    def score(image):
        output = network(image, right, projection, shift)
        return output.corners.square().mean() + output.class_logits.mean() + output.depth.mean()

    image = left.clone().requires_grad_()
    (gradient,) = torch.autograd.grad(score(image), image)
    direction = torch.randn(
        left.shape, dtype=left.dtype, generator=torch.Generator().manual_seed(1)
    )
    step = 1e-5
    with torch.no_grad():
        rise = (score(left + step * direction) - score(left - step * direction)) / (2 * step)
    assert (gradient * direction).sum().item() == pytest.approx(rise.item(), rel=1e-6)


def test_a_pair_alone_or_in_company_is_the_same(tiny):
    network = _network(tiny)
    inputs = _inputs(tiny.padded_size, batch=2)
    with torch.no_grad():
        together = network(*inputs)
        alone = network(*(part[1:] for part in inputs))
    torch.testing.assert_close(alone.corners[0], together.corners[1], atol=1e-3, rtol=1e-3)
    torch.testing.assert_close(alone.depth[0], together.depth[1], atol=1e-3, rtol=1e-3)


def test_voxels_lie_where_the_camera_sees_them(tiny):
    """With exact pixels, pixel 4 i is feature i of the w that -1..1 spans."""
    network = _network(replace(tiny, exact_pixels=True))
    height, width = tiny.padded_size
    places = network._places(_PROJECTION[None], (height, width))[0]
    z, y, x = (axis.centres() for axis in (tiny.grid.z, tiny.grid.y, tiny.grid.x))
    points = np.stack(np.meshgrid(z, y, x, indexing="ij"), -1)[..., ::-1]
    pixels, _ = project(_PROJECTION.numpy(), points)
    outermost = np.array([width // 4 - 1, height // 4 - 1])
    features = (places[..., :2].numpy() + 1) / 2 * outermost
    assert features == pytest.approx(pixels / 4)
    assert places[:, 0, 0, 2].numpy() == pytest.approx(tiny.sampled.position(z))


def test_corners_are_those_of_the_box_that_is_regressed(tiny):
    """Against the geometry of labels, whose corners are in another order."""
    network = _network(replace(tiny, anchors=(CAR, CYCLIST)))
    regressed = torch.zeros(1, 2, 10, 1, 1)
    regressed[0, 0, :, 0, 0] = torch.tensor(
        [0.3, -0.2, 0.5, 0.1, -0.1, 0.2, 0.4, -0.4, 0.0, 2.0]  # x, y, z, h, w, l, four turns
    )
    corners = BoxField(regressed, network.configuration).everywhere()[0, :, :, :, :, 0, 0].numpy()
    for angle, turn in enumerate((0.4, -0.4, 0.0, 2.0)):
        size = np.array([1.56, 1.6, 3.9]) * np.exp([0.1, -0.1, 0.2])
        yaw = angle * np.pi / 2 + np.tanh(turn) * np.pi / 4
        bottom = np.array([0.3, -0.2 + size[0] / 2, 0.5])
        expected = box_corners(bottom, size, yaw)
        distances = np.linalg.norm(corners[angle, 0][:, None] - expected[None], axis=-1)
        assert distances.min(1) == pytest.approx(np.zeros(8), abs=1e-6)
        assert sorted(distances.argmin(1)) == list(range(8))
        assert (corners[angle, 0, :4, 1] > corners[angle, 0, 4:, 1]).all()  # y points down
    straight = corners[0, 1]
    assert straight[0] == pytest.approx([1.76 / 2, 1.73 / 2, 0.6 / 2])
    assert straight[1] == pytest.approx([1.76 / 2, 1.73 / 2, -0.6 / 2])


def test_depth_of_the_features_stands_at_their_pixels(tiny):
    network = _network(tiny)
    left, right, projection, shift = _inputs(tiny.padded_size)
    with torch.no_grad():
        output = network(left, right, projection, shift)
    coarse = torch.einsum("bdhw,d->bhw", output.depth_logits.softmax(1), output.depth_bins)
    torch.testing.assert_close(output.depth[:, ::4, ::4], coarse)


def test_pyramid_can_be_switched_off_with_the_same_weights(tiny):
    network = _network(tiny)
    bare = _network(replace(tiny, features=replace(tiny.features, pyramid=False)))
    bare.load_state_dict(network.state_dict())
    inputs = _inputs(tiny.padded_size)
    with torch.no_grad():
        assert not torch.allclose(network(*inputs).depth, bare(*inputs).depth)


def test_small_is_the_same_class_and_small():
    configuration = DsgnConfiguration.preset("small")
    network = _network(configuration)
    assert sum(parameter.numel() for parameter in network.parameters()) < 4_000_000
    left, right, projection, shift = _inputs(configuration.padded_size)
    output = network(left.requires_grad_(), right.requires_grad_(), projection, shift)
    (output.corners.square().mean() + output.class_logits.square().mean()).backward()
    for image in (left, right):
        assert (image.grad.abs().sum(1) > 0).float().mean() > 0.99


def test_every_weight_of_small_fits_medium():
    with torch.device("meta"):
        small, medium = (
            DsgnNetwork(DsgnConfiguration.preset(name)).state_dict() for name in ("small", "medium")
        )
    assert {name: value.shape for name, value in small.items()} == {
        name: value.shape for name, value in medium.items()
    }
