"""Weights remember how their network enlarged its maps, which no shape of a tensor tells."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import torch

from avsec_gym.cli import run
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.map_files import write_disparity
from avsec_gym.kitti.sensor_files import write_image
from avsec_gym.perception.depth import corner_choice, psmnet
from avsec_gym.perception.depth.psmnet import PsmNet, PsmNetConfiguration
from avsec_gym.perception.depth.psmnet_depth import PsmNetDepth
from avsec_gym.perception.nn.pyramid_pooling import FeatureConfiguration
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import load_weights, read_card, save_weights
from avsec_gym.rig import kitti_rig

TINY = PsmNetConfiguration(
    disparities=32,
    features=FeatureConfiguration(
        first=8, stages=((8, 1),) * 4, windows=((8, 8), (4, 4)), pooled=4, matching=(8, 8)
    ),
    volume_channels=8,
)


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    """A network for tests stands in for the original's size."""
    monkeypatch.setitem(psmnet._PRESETS, "full", TINY)


def network(seed: int = 0) -> PsmNet:
    torch.manual_seed(seed)
    return PsmNet(TINY).eval()


def pair(height: int = 64, width: int = 96) -> StereoBatch:
    draw = np.random.default_rng(0)
    images = {i: draw.integers(0, 256, (height, width, 3), np.uint8) for i in (2, 3)}
    return batch_of_frames([SensorFrame("000000", kitti_rig().calibration, images)])


def published(folder: Path) -> Path:
    path = folder / "pretrained.tar"
    torch.save({"state_dict": network().state_dict()}, path)
    return path


def imported(folder: Path, *arguments: str) -> Path:
    out = folder / "psmnet.safetensors"
    command = ["weights", "import", str(published(folder)), "--network", "psmnet"]
    assert run([*command, "--out", str(out), "--overwrite", *arguments]) == 0
    return out


@pytest.mark.parametrize("step", [1, 2, 4])
def test_both_ways_differ_and_agree_on_what_a_constant_cost_means(step: int) -> None:
    """The mean of all disparities is the middle of the range, however the costs are enlarged."""
    for aligned in (False, True):
        whole = PsmNet(replace(TINY, aligned_corners=aligned, disparity_step=step))
        flat = whole._disparity(torch.zeros(1, 1, 8, 4, 4), (16, 16))
        assert torch.allclose(flat, torch.full_like(flat, 31 / 2))
    state = network().state_dict()
    edges, corners = (
        PsmNetDepth(TINY.with_corners(aligned), state).disparity_batch(pair())
        for aligned in (False, True)
    )
    assert (edges - corners).abs().max() > 0.01


def test_a_peak_at_a_plane_is_read_where_the_volume_put_it() -> None:
    """With aligned corners the last plane stands for the largest disparity, the first for 0."""
    for step in (1, 2, 4):
        net = PsmNet(replace(TINY, aligned_corners=True, disparity_step=step))
        for plane, disparity in ((0, 0.0), (7, 31.0)):
            cost = torch.zeros(1, 1, 8, 2, 2)
            cost[:, :, plane] = 1e4
            assert net._disparity(cost, (8, 8)) == pytest.approx(disparity, abs=1e-3)


@pytest.mark.parametrize("aligned", [True, False])
def test_import_keeps_the_choice_for_whoever_loads_it_later(tmp_path: Path, aligned: bool) -> None:
    out = imported(tmp_path, "--aligned-corners" if aligned else "--no-aligned-corners")
    card = read_card(out)
    assert card is not None
    assert card.configuration["aligned_corners"] is aligned
    assert card.configuration["features"]["aligned_corners"] is aligned
    loaded = PsmNetDepth("full", out)
    assert loaded.configuration == TINY.with_corners(aligned)
    expected = PsmNetDepth(TINY.with_corners(aligned), network().state_dict())
    one = pair()
    assert torch.equal(loaded.disparity_batch(one), expected.disparity_batch(one))
    # Whoever says the contrary is stopped: it would fit, and answer wrongly.
    with pytest.raises(ConfigurationError, match="aligned_corners"):
        PsmNetDepth(TINY.with_corners(not aligned), out)


def test_import_asks_where_nothing_says_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["weights", "import", str(published(tmp_path)), "--network"]
    assert run([*command, "psmnet"]) == 2
    error = " ".join(capsys.readouterr().err.split())
    assert "--aligned-corners" in error
    assert "--no-aligned-corners" in error
    assert "--pair" in error
    assert not list(tmp_path.glob("*.safetensors"))
    assert run([*command, "psmnet", "--aligned-corners", "--no-aligned-corners"]) == 2
    assert run([*command, "dsgn", "--aligned-corners"]) == 2


def test_import_knows_published_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    digest = corner_choice.hashlib.sha256(published(tmp_path).read_bytes()).hexdigest()
    monkeypatch.setitem(corner_choice._KNOWN, digest, True)
    card = read_card(imported(tmp_path))
    assert card is not None
    assert card.configuration["aligned_corners"] is True


@pytest.mark.parametrize("aligned", [True, False])
def test_import_measures_on_a_pair(tmp_path: Path, aligned: bool) -> None:
    """The truth is what the network answers in one of the two ways: that one is found."""
    size = (288, 400)
    one = pair(*size)
    files = [tmp_path / f"{name}.png" for name in ("left", "right", "disparity")]
    for path, view in zip(files, (one.left, one.right), strict=False):
        write_image(path, view[0].permute(1, 2, 0).numpy().astype(np.uint8))
    # As it is measured: on the lower rows alone.
    height = corner_choice._CROP[0]
    crop = replace(one, left=one.left[..., -height:, :], right=one.right[..., -height:, :])
    told = np.full(size, np.nan, np.float32)
    told[-height:] = PsmNetDepth(
        TINY.with_corners(aligned), network().state_dict()
    ).disparity_batch(crop)[0]
    write_disparity(files[2], told)
    card = read_card(imported(tmp_path, "--pair", *map(str, files)))
    assert card is not None
    assert card.configuration["aligned_corners"] is aligned


def test_a_pair_that_does_not_tell_is_refused(tmp_path: Path) -> None:
    image, disparity = np.zeros((300, 400, 3), np.uint8), np.full((300, 400), 9, np.float32)
    told = corner_choice.MeasuredPair(image, image, disparity, tmp_path)
    assert corner_choice.measured_corners({False: 1.2, True: 0.3}, told)
    assert not corner_choice.measured_corners({False: 0.3, True: 1.2}, told)
    for errors in ({False: 1.0, True: 0.9}, {False: 30.0, True: 31.0}):
        with pytest.raises(DataError, match="does not tell"):
            corner_choice.measured_corners(errors, told)
    places = [tmp_path / f"{name}.png" for name in ("left", "right", "disparity")]
    for place, width in zip(places[:2], (400, 300), strict=True):
        write_image(place, image[:, :width])
    write_disparity(places[2], disparity)
    with pytest.raises(DataError, match="sizes"):
        corner_choice.MeasuredPair.read(*places)
    write_image(places[1], image, overwrite=True)
    write_disparity(places[2], np.full((300, 400), np.nan, np.float32), overwrite=True)
    with pytest.raises(DataError, match="known"):
        corner_choice.MeasuredPair.read(*places)


def test_imports_of_earlier_releases_are_refused(tmp_path: Path) -> None:
    out, configuration = tmp_path / "psmnet.safetensors", asdict(TINY)
    del configuration["aligned_corners"]
    save_weights(out, network(), ModelCard("psmnet", configuration, source="published checkpoint"))
    with pytest.raises(DataError, match="Import the checkpoint again"):
        PsmNetDepth("full", out)
    # Trained here, before there was a choice: there was only one way.
    save_weights(out, network(), ModelCard("psmnet", configuration))
    assert PsmNetDepth("full", out).configuration == TINY
    save_weights(out, network(), ModelCard("psmnet", configuration | {"aligned_corners": 1}))
    with pytest.raises(DataError, match="neither true nor false"):
        PsmNetDepth("full", out)


def test_every_network_that_enlarges_maps_is_compared(tmp_path: Path) -> None:
    """By the name of the setting, wherever it stands in a configuration."""
    out = tmp_path / "weights.safetensors"
    inner = replace(TINY, features=replace(TINY.features, aligned_corners=True))
    save_weights(out, network(), ModelCard("psmnet", asdict(inner)))
    with pytest.raises(ConfigurationError, match=r"features\.aligned_corners=True"):
        load_weights(out, PsmNet(TINY))
