"""Points in view with their boxes: taken out once, kept on disk."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from avsec_gym.errors import DataError
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.perception.detectors.pointrcnn.configuration import (
    PointRcnnConfiguration,
    PointView,
)
from avsec_gym.perception.detectors.pointrcnn.points_input import points_in_view
from avsec_gym.perception.nn.points_in_boxes import points_in_boxes
from avsec_gym.perception.training.point_samples import PointSamples, prepare_point_samples
from avsec_gym.perception.training.scan_samples import NEEDED
from avsec_gym.perception.training.training_data import training_data

CONFIGURATION = replace(
    PointRcnnConfiguration.preset("small"), view=PointView((-8.0, 8.0), forward=(0.0, 25.0))
)

Prepare = Callable[[], PointSamples]


@pytest.fixture
def prepare(scan_folder: Path, tmp_path: Path) -> Prepare:
    data = training_data([scan_folder], needed=NEEDED)
    return lambda: prepare_point_samples(data.training, CONFIGURATION, tmp_path / "cache")


def test_samples_are_what_is_in_view_with_the_labels(prepare: Prepare, scan_folder: Path) -> None:
    samples, data = prepare(), KittiObject(scan_folder)
    assert len(samples) == 6
    for index in range(6):
        sample = samples[index]
        seen = points_in_view(data.frame(f"{index:06d}"), CONFIGURATION.view)
        np.testing.assert_allclose(sample.points, seen, atol=2.1e-3)
        label = data.labels(f"{index:06d}")
        expected = [*label.location[0], 1.5, 1.7, 4.0, 0.4]
        assert sample.objects[0] == pytest.approx(expected)
        inside = points_in_boxes(
            torch.from_numpy(sample.points), torch.from_numpy(sample.objects).float()
        )
        assert inside.sum() > 250
        assert len(sample.ignored) == 0
        assert samples.frame(index).id == f"{index:06d}"


def test_what_cannot_be_found_is_ignored_and_vans_are_cars(
    prepare: Prepare, scan_folder: Path
) -> None:
    label = scan_folder / "training" / "label_2" / "000001.txt"
    line = label.read_text().splitlines()[0]
    hidden = " ".join([*line.split()[:11], "-5", "1.6", "9", "0.1"])
    label.write_text("\n".join([line.replace("Car", "Van"), line.replace("Car", "Truck"), hidden]))
    sample = prepare()[1]
    assert len(sample.objects) == 1
    assert sample.ignored[:, :3] == pytest.approx(np.array([[-5, 1.6, 9]]))


def test_scans_are_read_once_and_anew_when_a_file_changes(
    scan_folder: Path, tmp_path: Path
) -> None:
    data = training_data([scan_folder], needed=NEEDED)
    told: list[tuple[int, int]] = []

    def prepare() -> None:
        prepare_point_samples(
            data.training,
            CONFIGURATION,
            tmp_path / "cache",
            on_progress=lambda *counts: told.append(counts),
        )

    prepare()
    prepare()
    assert told == [(number, 6) for number in range(1, 7)]
    label = scan_folder / "training" / "label_2" / "000003.txt"
    label.write_text(label.read_text() + "\n")
    prepare()
    assert told[6:] == [(1, 1)]
    assert not list((tmp_path / "cache").glob(".*"))


def test_a_broken_scan_is_named(prepare: Prepare, scan_folder: Path) -> None:
    path = scan_folder / "training" / "velodyne" / "000004.bin"
    path.write_bytes(path.read_bytes()[:-3])
    with pytest.raises(DataError, match=r"000004\.bin"):
        prepare()
