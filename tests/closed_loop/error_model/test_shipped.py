"""Error models by name: what the package ships is read, and held against today's weights."""

from __future__ import annotations

import json
import logging
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.error_model import shipped
from avsec_gym.closed_loop.error_model.drawn_errors import DrawnErrors
from avsec_gym.closed_loop.error_model.model import Ghosts
from avsec_gym.closed_loop.error_model.perception import ErrorModelPerception
from avsec_gym.closed_loop.error_model.shipped import (
    SHIPPED_MODELS,
    named_error_model,
    shipped_error_models,
)
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import ego_to_camera
from avsec_gym.perception.weights.weights_file import weights_file_hash


def test_each_detector_has_one_left_alone_and_under_attacks() -> None:
    attacks = ("", "_patch", "_thesis_pgd")
    wanted = {f"{name}{attack}" for name in ("dsgn", "stereo_rcnn") for attack in attacks}
    assert set(shipped_error_models()) == wanted


@pytest.mark.parametrize("name", shipped_error_models())
def test_a_shipped_one_is_of_todays_weights(name: str) -> None:
    model = named_error_model(name)
    assert model.card["weights"] == weights_file_hash(model.card["detector"])


@pytest.mark.parametrize("name", shipped_error_models())
def test_a_shipped_one_was_checked(name: str) -> None:
    model = named_error_model(name)
    assert len(model.card["check"]) == 3
    assert model.card["frames"] >= 100
    assert ErrorModelPerception(name).model == model


def test_other_weights_are_reported_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    name = shipped_error_models()[0]
    content = json.loads((SHIPPED_MODELS / f"{name}.json").read_text())
    content["card"]["weights"] = "0" * 64
    (tmp_path / f"{name}.json").write_text(json.dumps(content))
    monkeypatch.setattr(shipped, "SHIPPED_MODELS", tmp_path)
    monkeypatch.setattr(shipped, "_REPORTED", set())
    with caplog.at_level(logging.WARNING):
        named_error_model(name)
        named_error_model(name)
    [record] = caplog.records
    assert "other weights (00000000)" in record.getMessage()


@pytest.mark.parametrize(("weights", "reports"), [("0" * 64, 1), (None, 0)])
def test_so_are_those_of_a_file_of_one_s_own(
    weights: str | None,
    reports: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    content = json.loads((SHIPPED_MODELS / f"{shipped_error_models()[0]}.json").read_text())
    content["card"]["weights"] = weights
    own = tmp_path / "mine.json"
    own.write_text(json.dumps(content))
    monkeypatch.setattr(shipped, "_REPORTED", set())
    with caplog.at_level(logging.WARNING):
        named_error_model(own)
    assert len(caplog.records) == reports


def test_a_file_is_read_as_it_is(tmp_path: Path) -> None:
    name = shipped_error_models()[0]
    copy = tmp_path / "mine.json"
    shutil.copy(SHIPPED_MODELS / f"{name}.json", copy)
    assert named_error_model(copy) == named_error_model(name)


def test_what_is_not_there_is_an_error_with_the_names_of_those_that_are() -> None:
    with pytest.raises(ConfigurationError, match='Did you mean "stereo_rcnn"') as caught:
        ErrorModelPerception("stereo_rcn")
    assert "or a shipped error model: " in str(caught.value)
    with pytest.raises(DataError, match="stereo_rcnn") as missing:
        ErrorModelPerception("my/own.json")
    assert "my/own.json" in str(missing.value)


@pytest.mark.parametrize("name", shipped_error_models())
@pytest.mark.parametrize("away", [20.0, 70.0, 400.0])
def test_what_is_far_away_is_not_put_anywhere(name: str, away: float) -> None:
    """Scales grow with the distance, as far as models were fitted: at 400 m by 10^8 they did."""
    model = named_error_model(name)
    location, rotation_y = ego_to_camera(np.array([[away, 0.0, 0.0]]), np.array([1.65]))
    size = np.array([[1.5, 1.8, 4.0]])
    car = Boxes3D(location, size, rotation_y, np.ones(1), np.array(["Car"]))
    reach = 2.0 + 0.1 * away
    for seed in range(20):
        drawn = DrawnErrors(replace(model, found=(50.0, 0, 0, 0, 0, 0), ghosts=Ghosts()))
        drawn.begin(seed)
        found, _ = drawn.detect(car, np.array([1]), (0.0, 0.0, 0.0), 0.0)
        x, y, _ = found.poses[0]
        assert abs(x - away) <= reach + 1e-9
        assert abs(y) <= 1.5 + 1e-9
