"""Weights and patches that options name, and what is said where they are not."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path

import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.chapter5.trained import (
    patches_there,
    trained_detector,
    trained_inputs,
)
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import save_weights

NAME = "dsgn_without_pyramid"
SMALL = DsgnConfiguration.preset("small")


@pytest.fixture(scope="module")
def dsgn() -> DsgnDetector:
    return DsgnDetector()


def saved(path: Path, detector: DsgnDetector, pyramid: bool) -> dict[str, str]:
    """Options that name weights whose card says with which configuration they were trained."""
    trained = replace(SMALL, features=replace(SMALL.features, pyramid=pyramid))
    save_weights(path, detector.network, ModelCard("dsgn", configuration=asdict(trained)))
    return {NAME: str(path), "dsgn": str(path), "patches": str(path.parent)}


def test_without_its_pyramid_it_is_the_same_network_otherwise(
    dsgn: DsgnDetector, tmp_path: Path
) -> None:
    without = trained_detector(NAME, saved(tmp_path / "a.safetensors", dsgn, pyramid=False))
    assert isinstance(without, DsgnDetector)
    assert without.name == NAME
    assert without.rule == dsgn.rule
    features = without.configuration.features
    assert not features.pyramid
    assert replace(without.configuration, features=replace(features, pyramid=True)) == SMALL


def test_weights_of_a_network_with_pyramid_are_refused(dsgn: DsgnDetector, tmp_path: Path) -> None:
    options = saved(tmp_path / "a.safetensors", dsgn, pyramid=True)
    assert trained_detector("dsgn", options).name == "dsgn"
    with pytest.raises(DataError, match="with the spatial pyramid"):
        trained_detector(NAME, options)
    with pytest.raises(ConfigurationError, match="needs weights of its own"):
        trained_detector(NAME, {**options, NAME: ""})


def test_patches_are_looked_for_in_their_folder(dsgn: DsgnDetector, tmp_path: Path) -> None:
    options = saved(tmp_path / "dsgn.st", dsgn, pyramid=False)
    assert patches_there("dsgn", options) == ()
    for name in ("joint", "dsgn"):
        (tmp_path / f"{name}.safetensors").touch()
    assert patches_there("dsgn", options) == ("patch", "joint")
    assert patches_there(NAME, options) == ("joint",)
    named = trained_inputs(("dsgn", NAME), options)
    assert sorted(named) == [
        "patch dsgn", "patch joint", "weights of dsgn", f"weights of {NAME}"
    ]  # fmt: skip


def test_a_larger_dsgn_is_named_by_its_preset_or_known_by_its_card() -> None:
    options = {"dsgn": "medium", "stereo_rcnn": "medium", "patches": ""}
    medium = trained_detector("dsgn", options)
    assert isinstance(medium, DsgnDetector)
    assert medium.configuration == DsgnConfiguration.preset("medium")
    file = trained_inputs(("dsgn",), options)["weights of dsgn"]
    same = trained_detector("dsgn", {**options, "dsgn": str(file)})
    assert isinstance(same, DsgnDetector)
    assert same.configuration == medium.configuration
    with pytest.raises(DataError, match="No weights of stereo_rcnn_medium come with the package"):
        trained_detector("stereo_rcnn", options)
