"""Samples from folders: reduced rightly, kept on disk, chosen by splits."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.geometry import Floats
from avsec_gym.perception.training.sample import StereoSample
from avsec_gym.perception.training.stereo_samples import prepare_samples
from avsec_gym.perception.training.training_data import training_data


def test_reduced_samples_are_true_pairs(
    spot_folder: Path, tmp_path: Path, spot_errors: Callable[[StereoSample], Floats]
) -> None:
    data = training_data([spot_folder])
    samples = prepare_samples(data.training, (72, 300), tmp_path / "cache")
    assert len(samples) == 6
    for index in range(6):
        sample = samples[index]
        assert sample.size == (72, 300)
        assert spot_errors(sample).max() < 0.05
        (place,) = np.round(
            (sample.left_projection @ np.append(sample.truth.location[0], 1))[None, :2]
            / sample.truth.location[0, 2]
        ).astype(int)
        expected = 0.75 * 240 * (126 / 240) / (10 + index)
        assert sample.left_disparity[place[1], place[0]] == pytest.approx(expected, abs=0.01)
        box, original = sample.truth.box2d, samples.labels[index].box2d
        assert box is not None
        assert original is not None
        np.testing.assert_allclose((box + 0.5) / [0.75, 0.6, 0.75, 0.6] - 0.5, original)
    assert samples.sizes == [(120, 400)] * 6


def test_arrays_are_made_once_and_anew_when_an_image_changes(
    spot_folder: Path, tmp_path: Path
) -> None:
    data = training_data([spot_folder])
    told: list[int] = []

    def prepare() -> None:
        cache = tmp_path / "cache"
        prepare_samples(data.training, (40, 120), cache, on_progress=lambda n, _: told.append(n))

    prepare()
    prepare()
    assert told == [1, 2, 3, 4, 5, 6]
    image = spot_folder / "training" / "image_2" / "000001.png"
    image.write_bytes(image.read_bytes())
    prepare()
    assert len(told) == 12
    assert not list((tmp_path / "cache").glob(".*"))


def test_a_full_disk_is_an_error_before_any_frame_is_reduced(
    spot_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "posix_fallocate", full)
    told: list[int] = []
    with pytest.raises(DataError, match=r"left\.npy.*No space left on device.*free space"):
        prepare_samples(
            training_data([spot_folder]).training,
            (40, 120),
            tmp_path / "cache",
            on_progress=lambda done, _: told.append(done),
        )
    assert not told
    assert not (tmp_path / "cache").exists()


def test_without_disparity_maps_it_is_unknown(spot_folder: Path, tmp_path: Path) -> None:
    for path in (spot_folder / "training" / "disparity_2").iterdir():
        path.unlink()
    samples = prepare_samples(training_data([spot_folder]).training, None, tmp_path / "cache")
    assert samples[0].size == (120, 400)
    assert not samples[0].left_disparity.any()


def test_splits_and_other_folders(spot_folder: Path) -> None:
    split = training_data([spot_folder])
    assert [len(part[0].ids) for part in (split.training, split.validation)] == [6, 2]
    assert not set(split.training[0].ids) & set(split.validation[0].ids)
    whole = training_data([spot_folder], [spot_folder])
    assert [len(part[0].ids) for part in (whole.training, whole.validation)] == [8, 8]
    assert split.description()["training"][0]["frames"] == 6


def test_missing_data_name_the_command_that_makes_them(tmp_path: Path) -> None:
    nowhere = tmp_path / "nowhere"
    with pytest.raises(DataError, match=rf"no such folder.*avsec world make .*--out {nowhere}"):
        training_data([nowhere])


def test_broken_image_is_named_and_leaves_nothing_behind(spot_folder: Path, tmp_path: Path) -> None:
    path = spot_folder / "training" / "image_3" / "000002.png"
    path.write_bytes(path.read_bytes()[:-30])
    with pytest.raises(DataError, match=r"000002.png.*cut off"):
        prepare_samples(training_data([spot_folder]).training, (40, 120), tmp_path / "cache")
    assert not (tmp_path / "cache").exists()
