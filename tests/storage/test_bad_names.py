"""Names that no file can have are clear errors from Python, too, wherever a path is taken."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from torch.nn import Linear

from avsec_gym.agents.yaml_files import write_yaml
from avsec_gym.attacks.object_scan import read_object_scan
from avsec_gym.attacks.patch_files import Patch, load_patch, save_patch
from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.error_model.model import ErrorModel, write_error_model
from avsec_gym.drawing import scenario_picture
from avsec_gym.errors import DataError
from avsec_gym.kitti import (
    calibration,
    check,
    dataset,
    detections,
    label_folders,
    labels,
    map_files,
    oxts,
    raw,
    sensor_files,
    splits,
    timestamps,
    tracking,
    tracklets,
)
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.published import published_state
from avsec_gym.perception.weights.store import save_weights, write_card
from avsec_gym.perception.weights.torch_files import read_torch_file
from avsec_gym.planners.primitive_files import read_primitives, write_primitives
from avsec_gym.planners.primitives import generate_primitives
from avsec_gym.road_type import RoadType
from avsec_gym.runs.catalogue import experiment
from avsec_gym.runs.experiment import Configuration
from avsec_gym.runs.run import run_experiments
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.commonroad import read_commonroad, write_commonroad
from avsec_gym.scenario.commonroad_scenes import commonroad_folder
from avsec_gym.scenario.scene_sets import label_folder, labelled_scenarios
from avsec_gym.validation.thresholds import read_threshold_table
from avsec_gym.world.export import changed_files, make_data_set, suite_recipe
from avsec_gym.world.textures import library
from tests.full_disk import largest_file

READERS: dict[str, Callable[[Path], Any]] = {
    "labels": labels.read_labels,
    "detections": labels.read_detections,
    "label folder": label_folders.read_label_folder,
    "detection folder": detections.DetectionFolder,
    "calibration": calibration.read_calibration,
    "object data": dataset.KittiObject,
    "raw data": raw.KittiRaw,
    "drive": raw.Drive,
    "check": check.check_data,
    "split": splits.read_split,
    "image": sensor_files.read_image,
    "image size": sensor_files.read_image_size,
    "scan": sensor_files.read_points,
    "disparity": map_files.read_disparity,
    "mask": map_files.read_mask,
    "oxts": oxts.read_oxts,
    "timestamps": timestamps.read_timestamps,
    "tracking": tracking.read_tracking_labels,
    "tracklets": tracklets.read_tracklets,
    "object scan": read_object_scan,
    "patch": load_patch,
    "published weights": published_state,
    "torch file": lambda path: read_torch_file(path, remedy=""),
    "run": RunFolder.open,
    "thresholds": read_threshold_table,
    "data set": changed_files,
    "CommonRoad file": read_commonroad,
    "CommonRoad folder": commonroad_folder,
    "primitives": read_primitives,
    "scenes": labelled_scenarios,
    "labelled scenes": label_folder,
}


@pytest.mark.parametrize("name", ["n" * 300, "a\0b", "absent", "/".join(["deep"] * 2000)])
@pytest.mark.parametrize("reader", READERS.values(), ids=READERS.keys())
def test_a_bad_name_is_a_clear_error(
    tmp_path: Path, reader: Callable[[Path], Any], name: str
) -> None:
    with pytest.raises(DataError) as caught:
        reader(tmp_path / name)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 3000


def drawn(path: Path) -> None:
    scenario_picture.save_picture(Figure(), path)


CAR = Boxes3D(
    np.array([[0.0, 1.6, 20.0]]),
    np.array([[1.5, 1.6, 4.0]]),
    np.zeros(1),
    np.ones(1),
    np.array(["Car"]),
    np.array([[500.0, 100.0, 600.0, 200.0]]),
)
NO_OBJECTS, BLACK = Boxes3D.empty(), np.zeros((8, 8, 3), np.uint8)
WRITERS: dict[str, Callable[[Path], Any]] = {
    "labels": lambda path: labels.write_labels(path, CAR),
    "detections": lambda path: labels.write_detections(path, CAR),
    "image": lambda path: sensor_files.write_image(path, BLACK),
    "scan": lambda path: sensor_files.write_points(path, np.zeros((1, 4), np.float32)),
    "disparity": lambda path: map_files.write_disparity(path, np.ones((8, 8), np.float32)),
    "mask": lambda path: map_files.write_mask(path, np.ones((8, 8), np.uint8)),
    "tracking": lambda path: tracking.write_tracking_labels(
        path, {0: tracking.TrackedBoxes(CAR, np.array([1]))}
    ),
    "error model": lambda path: write_error_model(path, ErrorModel()),
    "scenario": lambda path: write_commonroad(PROBLEM, path),
    "primitives": lambda path: write_primitives(generate_primitives((6.0,)), path),
    "picture": drawn,
}
PROBLEM = build_planning_scenario(NO_OBJECTS, road_type=RoadType.STREET, id="free")


@pytest.mark.parametrize(
    "name", ["n" * 300 + ".png", "a\0b.png", "file/below.png", "folder.png", "there.png"]
)
@pytest.mark.parametrize("writer", WRITERS.values(), ids=WRITERS.keys())
def test_a_place_that_cannot_be_written_is_a_clear_error(
    tmp_path: Path, writer: Callable[[Path], Any], name: str
) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "there.png").write_text("mine")
    with pytest.raises(DataError) as caught:
        writer(tmp_path / name)
    assert str(caught.value).isprintable()
    # Nothing half written stays, and nothing is lost.
    assert {path.name for path in tmp_path.iterdir()} == {"file", "folder.png", "there.png"}
    assert (tmp_path / "there.png").read_text() == "mine"


FURTHER: dict[str, Callable[[Path], Any]] = {
    "patch": lambda path: save_patch(path, Patch.grey(3)),
    "weights": lambda path: save_weights(path, Linear(1, 1), ModelCard("dsgn")),
    "card of weights": lambda path: write_card(path, ModelCard("dsgn")),
    "yaml": lambda path: write_yaml(path, {}),
}
"""Writers of several files, or over what is there."""
FOLDERS: dict[str, Callable[[str], Any]] = {
    "data set": lambda path: make_data_set(suite_recipe("mixed", frames=1), path),
    "run": lambda path: run_experiments([experiment("unattacked")], Configuration("mixed"), path),
}
"""Writers of folders, for which ``.`` is one."""


@pytest.mark.parametrize("path", ["", ".", "/"])
@pytest.mark.parametrize("writer", [*WRITERS.values(), *FURTHER.values()], ids=[*WRITERS, *FURTHER])
def test_an_empty_path_is_a_clear_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, writer: Callable[[Any], Any], path: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DataError, match=r"path is empty|where a file is to be written"):
        writer(path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("writer", FOLDERS.values(), ids=FOLDERS.keys())
def test_an_empty_path_is_not_the_folder_that_one_is_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, writer: Callable[[str], Any]
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DataError, match="path is empty"):
        writer("")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("writer", WRITERS.values(), ids=WRITERS.keys())
def test_a_full_disk_is_a_clear_error(tmp_path: Path, writer: Callable[[Path], Any]) -> None:
    """Errors of the system while a file is written name none."""
    with largest_file(0), pytest.raises(DataError, match=r"cannot be written.*free space"):
        writer(tmp_path / "new.png")
    assert not list(tmp_path.iterdir())


def test_textures_without_room_are_named(tmp_path: Path) -> None:
    with largest_file(0), pytest.raises(DataError, match=r"textures\.npy.*cannot be written"):
        library._save(tmp_path / "textures.npy", lambda file: np.save(file, BLACK))
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("writer", WRITERS.values(), ids=WRITERS.keys())
def test_folders_above_a_file_are_made(tmp_path: Path, writer: Callable[[Path], Any]) -> None:
    writer(tmp_path / "deep" / "er" / "new.png")
    assert [path.name for path in (tmp_path / "deep" / "er").iterdir()] == ["new.png"]
