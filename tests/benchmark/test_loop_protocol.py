"""What drives on for each kind of entry."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avsec_gym.benchmark import loop_protocol
from avsec_gym.benchmark.loop_protocol import NoErrorModel, loop_settings
from avsec_gym.benchmark.loop_scenes import frozen_drives
from avsec_gym.benchmark.protocol import Entered
from avsec_gym.closed_loop.error_model.model import ErrorModel, write_error_model
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.perception.weights.weights_file import weights_file_hash

PATCH = {"name": "patch", "patch": "joint"}


def model(folder: Path, name: str, detector: Any, attack: Any = "", weights: Any = None) -> str:
    path = folder / f"{name}.json"
    card = {"detector": detector, "attack": attack, "weights": weights}
    write_error_model(path, ErrorModel(card=card))
    return str(path)


def test_a_planner_knows_the_truth_and_meets_the_frozen_errors() -> None:
    truth, *others = loop_settings(Entered.PLANNER, "gbfs")
    assert (truth.name, truth.perception, truth.planner) == ("truth", "truth", "gbfs")
    assert {each.name: each.model for each in others} == frozen_drives().error_models
    assert {(each.planner, each.against) for each in others} == {("gbfs", "truth")}
    assert [bool(each.attack) for each in others] == [False, True]


def test_a_detector_by_the_error_models_that_are_named(tmp_path: Path) -> None:
    files = [model(tmp_path, "patched", "mine", PATCH), model(tmp_path, "clean", "mine")]
    clean, patched = loop_settings(Entered.DETECTOR, "mine", files)
    assert (clean.name, clean.against, patched.name, patched.against) == (
        "unattacked", "", "patch", "unattacked",
    )  # fmt: skip
    assert patched.attack == PATCH
    assert (clean.white_box, patched.white_box) == (None, False)
    assert clean.model == tmp_path / "clean.json"
    # What is known by its results alone is taken at its word.
    results = {"name": "replayed", "detections": "somewhere"}
    assert len(loop_settings(Entered.DETECTOR, results, files)) == 2


def test_a_detector_without_one_is_left_out_with_the_remedy() -> None:
    for part in ("oracle", {"name": "dsgn", "weights": "no.safetensors"}):
        with pytest.raises(NoErrorModel, match=r"avsec error-model fit.*--error-model"):
            loop_settings(Entered.DETECTOR, part)


def test_shipped_ones_count_only_where_they_were_fitted_to_todays_weights(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    weights = weights_file_hash("dsgn")
    for name, of, attack in (("dsgn", weights, ""), ("dsgn_patch", weights, PATCH), ("x", "0", "")):
        model(tmp_path, name, "dsgn", attack, of)
    files = [str(path) for path in sorted(tmp_path.glob("*.json"))]
    monkeypatch.setattr(loop_protocol, "shipped_error_models", lambda: files)
    found = loop_settings(Entered.DETECTOR, "dsgn")
    assert [each.model.name for each in found if each.model] == ["dsgn.json", "dsgn_patch.json"]
    with pytest.raises(NoErrorModel):
        loop_settings(Entered.DETECTOR, {"name": "dsgn", "disparities": 3})
    attacked = loop_settings(Entered.ATTACK, PATCH)
    assert [each.name for each in attacked] == ["dsgn", "dsgn attacked"]
    with pytest.raises(NoErrorModel, match="under fgsm"):
        loop_settings(Entered.ATTACK, "fgsm")


def test_an_attack_by_the_errors_of_each_detector_of_the_package(tmp_path: Path) -> None:
    files = [
        model(tmp_path, f"{detector}{number}", detector, attack)
        for detector in ("stereo_rcnn", "dsgn")
        for number, attack in enumerate(("", {"name": "fgsm", "epsilon": 8}))
    ]
    found = loop_settings(Entered.ATTACK, {"name": "fgsm", "epsilon": 8}, files)
    assert [(each.name, each.against) for each in found] == [
        ("dsgn", ""), ("dsgn attacked", "dsgn"),
        ("stereo_rcnn", ""), ("stereo_rcnn attacked", "stereo_rcnn"),
    ]  # fmt: skip
    # Without an attack alone nothing can be compared.
    with pytest.raises(NoErrorModel, match="without and under fgsm"):
        loop_settings(Entered.ATTACK, "fgsm", [files[0]])


def test_error_models_of_something_else_are_refused(tmp_path: Path) -> None:
    cases: list[tuple[Entered, Any, list[str], str]] = [
        (Entered.DETECTOR, "mine", [model(tmp_path, "a", "yours")], "not of 'mine'"),
        (Entered.DETECTOR, "mine", [model(tmp_path, "b", "mine", PATCH)], "without an attack"),
        (
            Entered.DETECTOR, "mine",
            [model(tmp_path, "c", "mine"), model(tmp_path, "d", "mine")], "two are of 'unattacked'",
        ),
        (Entered.DETECTOR, "dsgn", [model(tmp_path, "e", "dsgn", "", "00")], "other weights"),
        (Entered.ATTACK, "fgsm", [model(tmp_path, "f", "mine", "fgsm")], "an attack meets dsgn"),
        (Entered.ATTACK, "fgsm", [model(tmp_path, "g", "dsgn", "patch")], "not of 'fgsm'"),
        (Entered.DETECTOR, "mine", ["dsgm"], "Did you mean"),
    ]  # fmt: skip
    for kind, part, files, message in cases:
        with pytest.raises((ConfigurationError, DataError), match=message):
            loop_settings(kind, part, files)
