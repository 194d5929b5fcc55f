"""Suites of single frames: exact KITTI layout, and truth that fits it."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import project, transform_points
from avsec_gym.kitti import KittiObject, check_data, read_disparity, read_labels, read_mask
from avsec_gym.rig import SensorRig
from avsec_gym.scenario.moving_flags import flagged
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import SUITES, Sensors, changed_files, make_data_set, suite_recipe
from avsec_gym.world.section import Surface

from .conftest import contents

IDS = ["000000", "000001"]


def test_the_readers_and_the_check_take_it(mixed: Path) -> None:
    data = KittiObject(mixed)
    assert data.ids() == data.ids("trainval") == IDS
    frame = data.frame("000001")
    assert frame.image(2).shape == frame.image(3).shape == (125, 414, 3)
    assert frame.stereo().baseline == pytest.approx(0.5327, abs=1e-3)
    assert len(frame.points) > 20_000
    (before,) = frame.previous
    assert (before.image(2) != frame.image(2)).any()
    report = check_data(mixed, deep=True)
    assert report.ok
    assert "Split trainval: 2 of 2 frames are here." in report.notes
    assert not [note for note in report.notes if "no f" in note or "without" in note]


def test_disparity_agrees_with_the_scan(mixed: Path) -> None:
    frame = KittiObject(mixed).frame("000001")
    calibration = frame.calibration
    disparity = read_disparity(mixed / "training/disparity_2/000001.png")
    there = transform_points(calibration.velodyne_to_camera, frame.points[:, :3])
    pixel, depth = project(calibration.projection(2), there)
    column, row = np.round(pixel).astype(int).T
    seen = (depth > 2) & (column >= 0) & (column < 414) & (row >= 0) & (row < 125)
    expected = calibration.focal_length() * calibration.baseline() / depth[seen]
    error = np.abs(disparity[row[seen], column[seen]] - expected)
    assert np.nanquantile(error, 0.9) < 1.0


def test_masks_belong_to_the_labels(mixed: Path) -> None:
    for id in IDS:
        boxes = read_labels(mixed / f"training/label_2/{id}.txt", keep_dont_care=True)
        instance = read_mask(mixed / f"training/instance_2/{id}.png")
        surface = read_mask(mixed / f"training/surface_2/{id}.png")
        assert instance.dtype == np.uint16
        assert surface.dtype == np.uint8
        objects = int((boxes.category != "DontCare").sum())
        assert set(np.unique(instance)) == set(range(objects + 1))
        assert (surface == Surface.ROAD).mean() > 0.1
        for line in range(objects):
            rows, columns = np.nonzero(instance == line + 1)
            assert boxes.box2d is not None
            left, top, right, bottom = boxes.box2d[line]
            assert columns.min() >= left - 2
            assert columns.max() <= right + 2
            assert rows.min() >= top - 2
            assert rows.max() <= bottom + 2
            kinds = np.unique(surface[rows, columns])
            assert set(kinds.tolist()) <= {Surface.VEHICLE, Surface.PERSON}


def test_flags_road_types_and_scenes(mixed: Path) -> None:
    training = mixed / "training"
    rows = list(csv.DictReader((training / "road_type.csv").read_text().splitlines()))
    assert [row["img_name"] for row in rows] == [f"{id}.png" for id in IDS]
    for id, row in zip(IDS, rows, strict=True):
        lines = read_labels(training / f"label_2/{id}.txt", keep_dont_care=True)
        boxes, remark = flagged(lines, training / f"moving/{id}.txt")
        assert remark is None
        scene = json.loads((training / f"scene/{id}.json").read_text())
        assert scene["road_type"] == ("highway", "street")[int(row["label"])]
        assert scene["ego_speed"] >= 0
        objects = [each for each in scene["objects"] if each["category"] in ("Car", "Van", "Truck")]
        assert boxes.moving is not None
        assert boxes.moving.tolist() == [each["moving"] for each in objects]
        assert all(each["speed"] > 0 for each in objects if each["moving"])


def test_a_frame_without_label_is_made_again(mixed: Path, tmp_path: Path, rig: SensorRig) -> None:
    root = tmp_path / "copy"
    shutil.copytree(mixed, root)
    (root / "training/label_2/000001.txt").unlink()
    (root / "training/image_3/000001.png").write_bytes(b"half")
    recipe = suite_recipe("mixed", 2, seed=1, sensors=Sensors(rig=rig), previous=1)
    assert make_data_set(recipe, root, workers=1).made == 1
    assert contents(root) == contents(mixed)
    assert changed_files(root, full=True) == []


@pytest.mark.slow
def test_equal_bytes_for_any_number_of_workers(mixed: Path, tmp_path: Path, rig: SensorRig) -> None:
    recipe = suite_recipe("mixed", 2, seed=1, sensors=Sensors(rig=rig), previous=1)
    make_data_set(recipe, tmp_path, workers=2)
    assert contents(tmp_path) == contents(mixed)


def test_every_suite_records_its_part_of_the_assets() -> None:
    for suite in SUITES:
        for assets in Assets:
            assert suite_recipe(suite, 1, assets=assets).settings["assets"] == assets.value
        assert suite_recipe(suite, 1).settings["assets"] == "all"


def test_impossible_numbers() -> None:
    for suite in SUITES:
        for frames in (0, 10**12):
            with pytest.raises(ConfigurationError, match=f"1 to 1,000,000, got {frames}"):
                suite_recipe(suite, frames)
        with pytest.raises(ConfigurationError, match="0 or more, got -1"):
            suite_recipe(suite, 1, seed=-1)
    with pytest.raises(ConfigurationError, match="there are street"):
        suite_recipe("moon", 1)
    with pytest.raises(ConfigurationError, match="0 to 3"):
        suite_recipe("mixed", 1, previous=4)
    for vehicles in (1, 10**12):
        with pytest.raises(ConfigurationError, match="from 2 to 100"):
            suite_recipe("connected", 1, vehicles=vehicles)
    for suite in ("connected", "raw"):
        for frames in (0, 10**12):
            with pytest.raises(ConfigurationError, match=r"drive_frames takes .* 1 to 10,000"):
                suite_recipe(suite, 1, drive_frames=frames)
    with pytest.raises(ConfigurationError, match="each once"):
        Sensors(cameras=(2, 7))
