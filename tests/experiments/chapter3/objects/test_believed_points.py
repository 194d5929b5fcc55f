"""Planes and scans of cars, shown to a detector that believes what is as deep as a car."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import MultiPoint, Polygon

from avsec_gym import registry
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.objects import believed_rates
from avsec_gym.experiments.chapter3.objects.believed_points import (
    CARS,
    PLANES,
    BelievedPoints,
    believed_cells,
    believed_inputs,
)
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import covering
from avsec_gym.experiments.chapter3.objects.pasted_cars import (
    CarInView,
    CarsOfFrames,
    pasted_box,
)
from avsec_gym.experiments.chapter3.objects.score_thresholds import ScoreThreshold
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import rectangle_corners, transform_points
from avsec_gym.kitti.labels import read_labels
from avsec_gym.kitti.raw import Drive
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.writing import write_raw_frame
from avsec_gym.rig import camera_rig
from avsec_gym.runs.catalogue import experiment
from avsec_gym.runs.experiment import CellResult, Configuration, Measurement
from avsec_gym.validation.recordings import RecordedFrame

RIG = camera_rig(
    (0.0, 0.56, -0.28, 0.28), focal_length=320.0, centre=(120.0, 60.0), size=(240, 120)
)
LABEL = "Car 0.00 0 -1.57 100.00 50.00 140.00 90.00 1.50 1.60 4.00 0.00 1.65 17.00 -1.57\n"
DRAWS = 6


def street(number: int, car: bool = True) -> SensorFrame:
    """A wall 25 m ahead, and a car 17 m ahead, of dots."""
    random = np.random.default_rng(number)
    low, high = np.array([[-9, -2, 25], [9, 1.6, 25.1]])
    spots = random.uniform(low, high, (2000, 3))
    if car:
        corners = np.array([[-0.79, 0.2, 15.1], [0.79, 1.6, 18.9]])
        spots = np.concatenate([spots, random.uniform(*corners, (400, 3))])
    places = np.c_[spots, np.ones(len(spots))] @ RIG.calibration.camera_to_velodyne.T
    image = np.zeros((120, 240, 3), np.uint8)
    images = dict.fromkeys(range(4), image)
    return SensorFrame(f"{number:010d}", RIG.calibration, images, places.astype(np.float32))


def write_drive(root: Path, frames: int, car: bool = True) -> Path:
    folder = root / "2026_01_01" / "2026_01_01_drive_0001_sync"
    for number in range(frames):
        write_raw_frame(folder, number, street(number, car))
        path = folder / "label_02" / "data" / f"{number:010d}.txt"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(LABEL if car else "")
    write_raw_calibration(root / "2026_01_01", RIG.calibration, image_size=RIG.size)
    return root


class Believer:
    """Knows the labels; other points are a car, hardly one if they are flat."""

    name = "believer"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        assert frame.origin is not None
        assert not frame.images, "a scan is looked at alone"
        known = replace(
            read_labels(frame.origin / "label_02" / "data" / f"{frame.id}.txt"),
            **dict.fromkeys(("truncation", "occlusion", "alpha", "box2d")),
        )
        known = replace(known, score=np.full(len(known), 0.6))
        clean = {tuple(point) for point in Drive(frame.origin).frame(int(frame.id)).points.tolist()}
        strange = [point[:3] for point in frame.points.tolist() if tuple(point) not in clean]
        if not strange:
            return known
        places = transform_points(frame.calibration.velodyne_to_camera, np.array(strange))
        # The least spread from above, whichever way they face.
        flat = np.linalg.svd(places[:, [0, 2]] - places[:, [0, 2]].mean(axis=0))[1][-1]
        score = 0.9 if flat / np.sqrt(len(places)) > 0.3 else 0.2
        x, _, z = places.mean(axis=0)
        bogus = Boxes3D([[x, 1.65, z]], [[1.5, 4.0, 4.0]], [0.0], [score], ["Car"])
        return Boxes3D.concatenate([known, bogus])


@pytest.fixture(autouse=True)
def believer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(registry._REGISTERED, (registry.Kind.DETECTOR, "believer"), Believer)


@pytest.fixture(scope="module")
def configuration(tmp_path_factory: pytest.TempPathFactory) -> Configuration:
    root = tmp_path_factory.mktemp("drives")
    fit, judged = write_drive(root / "fit", 2), write_drive(root / "judged", DRAWS)
    return Configuration(str(judged), options={"fit": str(fit), "believers": "believer"})


class Kept:
    """What cells came to, as a run keeps it."""

    def __init__(self, *cells: CellResult) -> None:
        self._cells = cells

    def detections(self, setting: str) -> dict[str, Boxes3D]:
        rows = (row for cell in self._cells for row in cell.detections)
        return {row.scenario: row.boxes for row in rows if row.setting == setting}

    def measurements(self, **where: Any) -> list[Measurement]:
        rows = (row for cell in self._cells for row in cell.measurements)
        return [
            row
            for row in rows
            if all(getattr(row, column) == value for column, value in where.items())
        ]


def test_cars_are_believed_and_planes_are_not(
    configuration: Configuration, monkeypatch: pytest.MonkeyPatch
) -> None:
    cells = believed_cells(configuration)
    assert experiment("believed").cells(configuration) == cells
    assert believed_inputs(configuration) == {}
    work = BelievedPoints(configuration)
    kept = Kept(*(work(**cell.arguments) for cell in cells))
    assert believed_rates.believed_summary(kept, configuration) is None  # type: ignore[arg-type]
    monkeypatch.setattr(believed_rates, "FEWEST", DRAWS)
    summary = believed_rates.believed_summary(kept, configuration)  # type: ignore[arg-type]
    assert summary is not None
    assert summary.objects == {"believer": ScoreThreshold(0.6, 1.0, 1.0)}
    told = {row.kind: row for row in summary.rows}
    assert list(told) == [*PLANES, *CARS]
    for kind, row in told.items():
        assert row.clean.count == 0
        expected = DRAWS if kind in CARS else 0
        assert (row.taken.count, row.newly.count) == (expected, expected)
        assert row.taken.of == DRAWS
    # What is not believed was seen.
    for plane in PLANES:
        scores = kept.measurements(setting=f"believed {plane}", name="believer attacked")
        assert {row.value for row in scores} == {0.2}
    before = kept.measurements(setting="believed plane", name="believer clean")
    assert np.isnan([row.value for row in before]).all()


def test_a_pasted_car_is_where_its_box_is() -> None:
    recorded = RecordedFrame("0", lambda: labelled)
    labelled = street(1)
    labels = Boxes3D([[0.0, 1.65, 17.0]], [[1.5, 1.6, 4.0]], [-1.57], [1.0], ["Car"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(f"{CarInView.__module__}.truth_of", lambda frame, camera: labels)
        cars = CarsOfFrames([recorded])
        scan = cars.first_of([3])
        assert cars.first_of([0]) is scan
        assert cars.first_of([]) is None
    assert scan is not None
    assert len(scan.points) == 400
    for seed in range(3):
        tampered = CarInView(scan, 2).attack(street(2), seed)
        plane = LidarSpoofing().attack(street(2), seed)
        distance, bearing = LidarSpoofing().place(street(2), seed)
        assert plane.settings == {"distance": distance, "bearing": bearing}
        assert tampered.points is not None
        # The side that is nearest stands where the plane does.
        ahead, left = tampered.frame.points[tampered.points, :2].T
        along = ahead * np.cos(bearing) + left * np.sin(bearing)
        assert along.min() == pytest.approx(distance, abs=0.05)
        box = pasted_box(scan, tampered)
        places = transform_points(
            RIG.calibration.velodyne_to_camera, tampered.frame.points[tampered.points, :3]
        )
        (corners,) = rectangle_corners(box.poses, box.length, box.width)
        height, middle = box.dimensions[0, 0], places[:, 1]
        assert box.location[0, 1] - height - 0.1 < middle.min()
        assert middle.max() < box.location[0, 1] + 0.1
        seen_from_above = MultiPoint(np.c_[places[:, 2], -places[:, 0]])
        assert Polygon(corners).buffer(0.01).contains(seen_from_above)
        assert seen_from_above.convex_hull.area > 0.8 * Polygon(corners).area
        assert covering(Boxes3D.concatenate([labels, box]), box).tolist() == [False, True]
    assert not covering(labels, Boxes3D.empty()).any()


def test_without_a_labelled_car_there_are_planes_only(tmp_path: Path) -> None:
    fit, judged = write_drive(tmp_path / "fit", 2, car=False), write_drive(tmp_path / "judged", 2)
    options = {"fit": str(fit), "believers": "believer"}
    work = BelievedPoints(Configuration(str(judged), options=options))
    for number in range(2):
        result = work("judged", number)
        assert {row.setting for row in result.measurements} == {
            f"believed {plane}" for plane in PLANES
        }
