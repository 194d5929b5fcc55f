"""Assets of data that networks are trained on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.errors import DataError
from avsec_gym.perception.training import training_assets
from avsec_gym.perception.training.tasks import TaskOptions, make_task
from avsec_gym.perception.training.training_assets import remark_on_assets, training_suite
from avsec_gym.world.assets import Assets


def data_of(folder: Path, settings: dict[str, Any] | None) -> Path:
    folder.mkdir()
    if settings is not None:
        manifest = {"format": 1, "complete": True, "settings": settings, "files": {}}
        (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


def test_data_of_judging_assets_are_remarked_on(tmp_path: Path) -> None:
    train = data_of(tmp_path / "train", {"assets": "train"})
    real = data_of(tmp_path / "real", None)
    assert remark_on_assets([train, real, tmp_path / "nowhere"]) is None
    judge = data_of(tmp_path / "judge", {"assets": "judge"})
    # The first edition's manifests name no assets: it had all of them.
    first = data_of(tmp_path / "first", {"suite": "mixed"})
    remark = remark_on_assets([train, judge, first, judge])
    assert remark is not None
    assert f": {judge} (judge), {first} (all). " in remark


def test_a_task_remarks_once(tmp_path: Path) -> None:
    judge = data_of(tmp_path / "judge", {"assets": "judge"})
    remarks: list[str] = []
    options = TaskOptions("small", (judge,), (judge,), tmp_path / "cache", on_report=remarks.append)
    with pytest.raises(DataError):
        make_task("road_type", options)
    assert len(remarks) == 1
    assert "avsec world make --assets train" in remarks[0]


@pytest.mark.parametrize("name", ["street", "highway", "mixed", "raw"])
def test_what_is_trained_on_without_data_is_of_training_assets(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    made = {}

    def cached(named: str, recipe: Any) -> Path:
        made[named] = recipe
        return tmp_path

    monkeypatch.setattr(training_assets, "cached", cached)
    assert training_suite(name) == tmp_path
    (recipe,) = made.values()
    assert list(made) == [f"{name}-train"], "beside the default suite, in a folder of its own"
    assert recipe.settings["assets"] == Assets.TRAIN
    if name == "raw":
        drives = len(recipe) // recipe.settings["drive_frames"]
        assert drives >= 4, "every fourth drive is held out"
