"""How far a patch spreads: random weights, against brute force."""

import copy
from dataclasses import replace

import numpy as np
import pytest
import torch

from avsec_gym.attacks.patch_files import Patch
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter5.feature_spread import LAYERS, feature_spread, features
from avsec_gym.experiments.chapter5.feature_spread_figure import draw_feature_spread
from avsec_gym.perception.detectors import make_detector
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.nn.resnet import Bottleneck
from avsec_gym.perception.stereo_batch import batch_of_images
from avsec_gym.rig import kitti_rig

SMALL = DsgnConfiguration.preset("small")
CONVOLUTIONS = [f"conv{i}" for i in range(1, 6)]
BRANCHES = [f"branch{i}" for i in range(1, 5)]
FUSIONS = ["fusion1", "fusion2"]


@pytest.fixture(scope="module")
def dsgn():
    torch.manual_seed(0)
    return DsgnDetector()


@pytest.fixture(scope="module")
def stereo_rcnn():
    torch.manual_seed(0)
    detector = StereoRcnnDetector()
    for module in detector.network.modules():
        if isinstance(module, Bottleneck):  # Else residual blocks pass on what they get.
            torch.nn.init.ones_(module.bn3.weight)
    return detector


@pytest.fixture(scope="module")
def spreads(dsgn, stereo_rcnn):
    return [feature_spread(each, Patch.noise(1), images=2) for each in (stereo_rcnn, dsgn)]


def test_the_layers_are_those_of_the_thesis(spreads):
    for spread in spreads:
        shown = [layer.layer for layer in spread.layers]
        assert shown == [name for name in LAYERS if name in shown]
    upward = ["upsample1", "smooth1", "smooth2", "smooth3", "maxpool1"]
    assert [layer.layer for layer in spreads[0].layers] == [*CONVOLUTIONS, "conv6", *upward]
    assert [layer.layer for layer in spreads[1].layers] == [*CONVOLUTIONS, *BRANCHES, *FUSIONS]


def test_the_first_layer_shows_the_patch_itself(spreads):
    for spread in spreads:
        first = spread.layers[0]
        extent = first.extent
        assert spread.patch_radius == 38
        assert 38 <= extent.radius <= extent.reach <= 38 + 4 * extent.cell
        assert 38 <= extent.radius_absolute <= extent.reach
        middle = first.difference.shape[0] // 2
        assert first.difference[middle, middle] > 0.2 * first.difference.max()


def test_deeper_layers_can_reach_further(spreads):
    """Residual stages widen what a place sees; Stereo R-CNN's halve the resolution besides."""
    for spread in spreads:
        reach = [layer.extent.reach for layer in spread.layers[:5]]
        assert reach == sorted(reach)
    rcnn = {layer.layer: layer.extent for layer in spreads[0].layers}
    assert rcnn["conv5"].cell == pytest.approx(8 * rcnn["conv2"].cell)
    assert rcnn["conv5"].radius > 2 * rcnn["conv1"].radius


def test_pooled_means_and_what_joins_them_see_everything(spreads):
    layers = {layer.layer: layer.extent for layer in spreads[1].layers}
    whole = np.sqrt(375 * 1242 / np.pi)
    assert layers["fusion2"].reach == pytest.approx(whole, rel=0.01)
    assert layers["conv5"].reach < whole / 2


def test_without_the_pyramid_the_branches_are_missing_and_the_reach_ends(dsgn):
    configuration = replace(SMALL, features=replace(SMALL.features, pyramid=False))
    without = DsgnDetector(configuration, weights=dsgn.network.state_dict())
    spread = feature_spread(without, Patch.noise(1), images=2)
    assert [layer.layer for layer in spread.layers] == [*CONVOLUTIONS, *FUSIONS]
    assert spread.layers[-1].extent.reach < 200


def test_differences_are_means_over_channels_of_features_with_and_without(dsgn):
    """The whole way by hand: two noise images, a disc, and the network's own first layers."""
    patch = Patch.noise(3)
    spread = feature_spread(dsgn, patch, 5, images=2)
    generator = torch.Generator().manual_seed(5)
    left = torch.rand(2, 3, 375, 1242, generator=generator) * 255
    attacked = left.clone()
    v, u = np.indices((375, 1242))
    inside = np.hypot(v - 187, u - 620.5) < 37
    for row, column in zip(*np.nonzero(inside), strict=True):
        attacked[:, :, row, column] = patch.pixels[:, row - 149, min(int(column - 582.5), 75)]
    maps = []
    for images in (left, attacked):
        batch = batch_of_images(images, images, [kitti_rig().calibration] * 2)
        with torch.no_grad():
            maps.append(dsgn.network.feature_extraction.firstconv(dsgn.prepare(batch).left))
    difference = (maps[0] - maps[1]).abs().mean((0, 1)).numpy()
    middle = difference[int(187.5 * 64 / 375) - 2 :][:4, int(621 * 384 / 1242) - 2 :][:, :4].mean()
    given = spread.layers[0].difference
    assert given[108:132, 114:127].mean() == pytest.approx(middle, rel=0.15)


def test_what_can_be_reached_is_what_changes_without_normalisation_over_the_image(dsgn):
    """Where GroupNorm is away, nothing beyond the reach differs, and its rim does."""
    network = copy.deepcopy(dsgn.network)
    for module in list(network.modules()):
        for name, part in list(module.named_children()):
            if isinstance(part, torch.nn.GroupNorm):
                setattr(module, name, torch.nn.Identity())
    bare = DsgnDetector()
    bare.network = network
    spread = feature_spread(bare, Patch.noise(1), images=2, threshold=1e-9)
    for layer in spread.layers[:3]:
        assert layer.extent.radius == pytest.approx(layer.extent.reach, rel=0.05)


def test_the_same_seed_gives_the_same_maps(dsgn, spreads):
    again = feature_spread(dsgn, Patch.noise(1), images=2)
    for one, other in zip(spreads[1].layers, again.layers, strict=True):
        np.testing.assert_array_equal(one.difference, other.difference)
        figures = ({**vars(layer), "difference": None} for layer in (one, other))
        assert next(figures) == next(figures)


def test_nothing_is_left_hanging_on_the_network(dsgn):
    features(dsgn.network, torch.zeros(1, 3, 128, 768))
    assert not any(module._forward_hooks for module in dsgn.network.modules())
    assert isinstance(dsgn.network.feature_extraction.firstconv[0][1], torch.nn.GroupNorm)


def test_what_is_not_known_is_refused(dsgn):
    with pytest.raises(ConfigurationError, match="oracle"):
        feature_spread(make_detector("oracle"), Patch.grey())
    with pytest.raises(ConfigurationError, match="square"):
        feature_spread(dsgn, Patch.grey(), crop=400)


def test_the_figure_is_drawn(spreads, tmp_path):
    titles = ("Stereo R-CNN", "DSGN")
    draw_feature_spread(dict(zip(titles, spreads, strict=True)), tmp_path / "spread.png")
    assert (tmp_path / "spread.png").stat().st_size > 20_000
