"""How located and repaired damage is judged."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3 import localisation
from avsec_gym.experiments.chapter3.localisation import (
    Located,
    Overlap,
    attacks_of,
    found_again,
    overlap,
    summary,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.writing import write_raw_frame
from avsec_gym.rig import camera_rig


def test_overlap_of_two_areas() -> None:
    found, true = np.zeros((2, 10, 10), bool)
    found[:, :6] = True
    true[:, 4:] = True
    assert overlap(found, true) == Overlap(20 / 100, 20 / 60, 20 / 60)
    assert overlap(found, ~true | true) == Overlap(0.6, 1.0, 0.6)
    assert overlap(true & ~true, true & ~true) == Overlap(None, None, None)


def test_objects_are_found_again_by_place_and_category() -> None:
    count = 3
    objects = Boxes3D(
        np.zeros((count, 3)),
        np.ones((count, 3)),
        np.zeros(count),
        np.ones(count),
        np.array(["Car", "Car", "Cyclist"]),
        box2d=np.array([[0, 0, 100, 100], [200, 0, 300, 100], [400, 0, 500, 100.0]]),
    )
    assert found_again(objects, objects) == count
    right = np.array([1.0, 0.0, 1.0, 0.0])
    assert objects.box2d is not None
    moved = replace(objects, box2d=objects.box2d + 40 * right)
    assert found_again(objects, moved) == 0
    moved = replace(objects, box2d=objects.box2d + 30 * right)
    assert found_again(objects, moved) == count
    others = replace(objects, category=np.array(["Car", "Pedestrian", "Car"]))
    assert found_again(objects, others) == 1
    assert found_again(objects, Boxes3D.empty()) == 0


def test_attacks_are_summed_up_by_name() -> None:
    rows = [
        Located("0", "spot", Overlap(0.5, 1.0, 0.5), objects=3, found_before=1, found_after=2),
        Located("1", "spot", Overlap(0.9, 1.0, 0.9), objects=2, found_before=0, found_after=2),
        Located("2", "spot", Overlap(None, None, None)),
    ]
    told = summary(rows)["spot"]
    assert told["frames"] == 3
    assert told["iou"] == pytest.approx(0.7)
    assert told["lowest_iou"] == 0.5
    assert told["error_after"] is None
    assert (told["objects"], told["found_before"], told["found_after"]) == (5, 1, 4)


def test_frames_of_drives_are_told_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rig = camera_rig(
        [0.0, 0.56, -0.28, 0.28], focal_length=200.0, centre=(120.0, 60.0), size=(240, 120)
    )
    dots = np.random.default_rng(0).integers(0, 256, (120, 240, 3), np.uint8)
    points = np.array([[8.0, 0.0, 0.0, 0.5]], np.float32)
    frame = SensorFrame("0", rig.calibration, {2: dots, 3: dots}, points)
    day = tmp_path / "2026_01_01"
    drives = [day / f"2026_01_01_drive_{number:04d}_sync" for number in (1, 2)]
    for drive in drives:
        write_raw_frame(drive, 0, frame)
    write_raw_calibration(day, rig.calibration, image_size=rig.size)
    monkeypatch.setattr(localisation, "attacks_of", lambda: {"spot": Facula(2, 200.0)})
    named = [f"--kitti-raw={drive}" for drive in drives]
    assert localisation.main([*named, "--out", str(tmp_path / "out")]) == 0
    rows = json.loads((tmp_path / "out" / "localisation.json").read_text())["rows"]
    assert [row["frame"] for row in rows] == [f"{drive.name}/0000000000" for drive in drives]


def test_every_attack_has_a_name_of_its_own_sensor() -> None:
    assert {next(iter(attack.sensors)) for attack in attacks_of(3).values()} == {3, "lidar"}
