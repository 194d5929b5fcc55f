"""PSMNet: keys, sizes, gradients, its loss."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.depth.psmnet import PsmNet, PsmNetConfiguration, psmnet_loss
from avsec_gym.perception.nn.pyramid_pooling import FeatureConfiguration

_TINY = PsmNetConfiguration(
    disparities=32,
    features=FeatureConfiguration(
        first=8,
        stages=((8, 1), (8, 1), (8, 1), (8, 1)),
        windows=((8, 8), (4, 4)),
        pooled=4,
        matching=(8, 4),
    ),
    volume_channels=8,
)


def _pair(dtype=torch.float32):
    generator = torch.Generator().manual_seed(0)
    images = torch.randn(2, 1, 3, 48, 64, generator=generator, dtype=dtype)
    return images[0].requires_grad_(), images[1].requires_grad_()


def _network(configuration=_TINY):
    torch.manual_seed(0)
    return PsmNet(configuration)


def test_keys_are_the_originals(shared):
    lines = (shared / "parity" / "psmnet_keys.txt").read_text().splitlines()
    with torch.device("meta"):
        network = PsmNet(PsmNetConfiguration.preset("full"))
    ours = [f"{key} {tuple(value.shape)}" for key, value in network.state_dict().items()]
    assert sorted(ours) == sorted(lines)
    assert sum(parameter.numel() for parameter in network.parameters()) == 5_224_768


def test_three_disparities_in_training_one_otherwise():
    network = _network()
    training = network(*_pair())
    evaluation = network.eval()(*_pair())
    assert [disparity.shape for disparity in training] == [(1, 48, 64)] * 3
    assert [disparity.shape for disparity in evaluation] == [(1, 48, 64)]
    assert evaluation[0].min() >= 0
    assert evaluation[0].max() <= 31


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_gradient_reaches_nearly_every_pixel_of_both_images(dtype):
    network = _network().to(dtype).eval()
    left, right = _pair(dtype)
    (disparity,) = network(left, right)
    assert disparity.dtype == dtype
    (disparity**2).sum().backward()
    for image in (left, right):
        assert (image.grad.abs().sum(1) > 0).float().mean() > 0.99


@pytest.mark.slow
def test_a_pair_that_is_learnt_by_heart_is_known():
    """Forty steps on one scene: a slanted surface, textured, of known disparity."""
    torch.manual_seed(0)
    u = torch.arange(64.0).expand(48, 64)
    truth = (4 + u / 8)[None]
    texture = torch.randn(1, 3, 48, 128)
    left = torch.nn.functional.interpolate(texture, size=(48, 64), mode="bilinear")
    places = torch.stack([(u + truth[0]) / 63.5 - 1, torch.linspace(-1, 1, 48)[:, None] + 0 * u], 2)
    right = torch.nn.functional.grid_sample(left, places[None], align_corners=True)
    network = _network()
    optimiser = torch.optim.Adam(network.parameters(), 0.01)
    for _ in range(40):
        loss = psmnet_loss(network(left, right), truth, 32)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    network.eval()
    errors = (network(left, right)[0] - truth).abs()
    assert errors.median() < 1.5  # against 8 of the untrained network's guess of the middle


def test_loss_by_hand():
    truth = torch.tensor([[[0.0, 10.0, 20.0, 99.0]]])  # unknown, known, known, beyond the planes
    first, second, third = (truth + distance for distance in (0.5, 2.0, -3.0))
    smooth = torch.tensor([0.5 * 0.25, 2 - 0.5, 3 - 0.5])
    expected = (smooth * torch.tensor([0.5, 0.7, 1.0])).sum()
    torch.testing.assert_close(psmnet_loss([first, second, third], truth, 64), expected)
    torch.testing.assert_close(psmnet_loss([third], truth, 64), smooth[2])


def test_nothing_known_is_no_loss():
    predicted = torch.ones(1, 2, 2, requires_grad=True)
    loss = psmnet_loss([predicted], torch.zeros(1, 2, 2), 64)
    loss.backward()
    assert loss == 0
    assert not predicted.grad.any()


def test_sizes_that_hourglasses_cannot_halve_are_refused():
    with pytest.raises(ConfigurationError, match="multiples of 16"):
        replace(_TINY, disparities=40)
    with pytest.raises(ConfigurationError, match="multiples of 16"):
        replace(_TINY, input_size=(100, 320))
    with pytest.raises(ConfigurationError, match="no PSMNet is called 'huge'"):
        PsmNetConfiguration.preset("huge")


def test_small_is_small():
    network = PsmNet(PsmNetConfiguration.preset("small"))
    assert sum(parameter.numel() for parameter in network.parameters()) < 4_000_000


@pytest.mark.parametrize("step", [1, 2, 4])
def test_planes_mean_the_same_disparities_whatever_the_step(step):
    """Plane k of the volume stands for the middle of pixels 4k to 4k + 3."""
    network = _network(replace(_TINY, disparity_step=step))
    parabola = -20 * (torch.arange(8.0) - 4.0) ** 2
    cost = parabola[:, None, None].expand(8, 12, 16)[None, None]
    found = network._disparity(cost, (48, 64))
    assert found.shape == (1, 48, 64)
    torch.testing.assert_close(found, torch.full_like(found, 17.5), atol=1e-3, rtol=0)
    with pytest.raises(ConfigurationError, match="disparity_step is 1, 2 or 4"):
        replace(_TINY, disparity_step=3)
