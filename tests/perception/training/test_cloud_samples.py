"""Scans with labels: cropped, sorted, kept on disk."""

from __future__ import annotations

from collections.abc import Callable
from io import FileIO
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.geometry import project, transform_points
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.perception.detectors.pixor.configuration import BirdEyeRegion
from avsec_gym.perception.detectors.pixor.targets import owners
from avsec_gym.perception.training.cloud_samples import (
    MARGIN,
    CloudSamples,
    prepare_cloud_samples,
)
from avsec_gym.perception.training.scan_samples import NEEDED
from avsec_gym.perception.training.training_data import training_data
from avsec_gym.storage.npy_rows import NewFile

REGION = BirdEyeRegion((0.0, 12.8), (-6.4, 6.4), (-2.5, 1.0), 0.2, 0.5)

Prepare = Callable[[], CloudSamples]


@pytest.fixture
def prepare(scan_folder: Path, tmp_path: Path) -> Prepare:
    data = training_data([scan_folder], needed=NEEDED)
    return lambda: prepare_cloud_samples(data.training, REGION, "Car", tmp_path / "cache")


def test_samples_are_the_scans_with_the_labels_seen_from_above(
    prepare: Prepare, scan_folder: Path
) -> None:
    samples, data = prepare(), KittiObject(scan_folder)
    assert len(samples) == 6
    for index in range(6):
        sample, points = samples[index], samples.frame(index).points
        near = (points[:, 0] < 12.8 + MARGIN) & (np.abs(points[:, 1]) < 6.4 + MARGIN)
        assert 0 < near.sum() < len(points)
        np.testing.assert_allclose(sample.points, points[near], atol=2.1e-3)
        (car,) = sample.rectangles
        label = data.labels(f"{index:06d}")
        x, _, z = label.location[0]
        assert car == pytest.approx([z + 0.27, -x, 4.0, 1.7, -0.4 - np.pi / 2])
        assert (owners(sample.points[:300, :2], car[None]) == 0).mean() > 0.99
        assert len(sample.ignored) == 0


def test_labels_are_complete_where_the_camera_looks(prepare: Prepare) -> None:
    samples = prepare()
    right, left = samples[0].azimuths
    directions = np.linspace(-1, 1, 401)
    # So far that it does not matter that camera and LiDAR stand apart.
    places = 1e5 * np.stack([np.cos(directions), np.sin(directions), 0 * directions], 1)
    calibration = samples.frame(0).calibration
    seen = transform_points(calibration.velodyne_to_camera, places)
    pixels, _ = project(calibration.projection(2), seen)
    shown = (pixels[:, 0] > -0.5) & (pixels[:, 0] < 399.5)
    np.testing.assert_array_equal(shown, (directions > right) & (directions < left))


def test_what_cannot_be_found_is_ignored(prepare: Prepare, scan_folder: Path) -> None:
    training = scan_folder / "training"
    label = training / "label_2" / "000001.txt"
    line = label.read_text().splitlines()[0]
    # A van beside it, a lorry, and a car that no point is on.
    others = [
        line.replace("Car", "Van"),
        line.replace("Car", "Truck"),
        " ".join([*line.split()[:11], "-9", "1.6", "9", "0.1"]),
    ]
    label.write_text("\n".join([line, *others]) + "\n")
    scan = training / "velodyne" / "000002.bin"
    points = np.fromfile(scan, "<f4").reshape(-1, 4)
    points[296:].tofile(scan)  # Four of the car are left.
    samples = prepare()
    assert [len(samples[index].rectangles) for index in (0, 1, 2)] == [1, 1, 0]
    assert [len(samples[index].ignored) for index in (0, 1, 2)] == [0, 2, 1]
    assert samples[1].ignored[1, :2] == pytest.approx([9.27, 9.0])


def test_scans_are_cropped_once_and_anew_when_a_file_changes(
    scan_folder: Path, tmp_path: Path
) -> None:
    data = training_data([scan_folder], needed=NEEDED)
    told: list[int] = []

    def prepare() -> None:
        prepare_cloud_samples(
            data.training,
            REGION,
            "Car",
            tmp_path / "cache",
            on_progress=lambda n, _: told.append(n),
        )

    prepare()
    prepare()
    assert told == [1, 2, 3, 4, 5, 6]
    label = scan_folder / "training" / "label_2" / "000003.txt"
    label.write_text(label.read_text())
    prepare()
    assert len(told) == 12
    assert not list((tmp_path / "cache").glob(".*"))


def test_a_broken_scan_is_named_and_leaves_nothing_behind(
    prepare: Prepare, scan_folder: Path, tmp_path: Path
) -> None:
    path = scan_folder / "training" / "velodyne" / "000004.bin"
    path.write_bytes(path.read_bytes()[:-3])
    with pytest.raises(DataError, match=r"000004.bin"):
        prepare()
    assert not (tmp_path / "cache").exists()


@pytest.mark.parametrize("file", ["points.raw", "points.npy"])
def test_a_full_disk_is_an_error_that_names_the_file(
    prepare: Prepare, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str
) -> None:
    real = NewFile.write

    def write(self: NewFile, content: bytes, place: int | None = None) -> None:
        # A file that the system lets no write through to, as where the disk is full.
        if self._path.name == file:
            self._file.close()
            self._file = FileIO("/dev/full", "w")
        real(self, content, place)

    monkeypatch.setattr(NewFile, "write", write)
    with pytest.raises(DataError, match=rf"{file}.*No space left on device.*free space"):
        prepare()
    assert not (tmp_path / "cache").exists()


def test_folders_without_scans_are_named(spot_folder: Path) -> None:
    with pytest.raises(DataError, match="velodyne"):
        training_data([spot_folder], needed=NEEDED)
