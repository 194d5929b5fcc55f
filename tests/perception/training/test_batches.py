"""Batches are the same, whoever prepares them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import torch

from avsec_gym.errors import DataError
from avsec_gym.perception.training import batches as module
from avsec_gym.perception.training import stereo_samples
from avsec_gym.perception.training.batches import batches
from avsec_gym.perception.training.configuration import Augmentation, TrainingConfiguration
from avsec_gym.perception.training.stereo_samples import prepare_samples
from avsec_gym.perception.training.stereo_task import StereoTask
from avsec_gym.perception.training.training_data import training_data

CONFIGURATION = TrainingConfiguration(batch=2, seed=3)


def lengths(truth: Any) -> list[float]:
    return [float(boxes.length.sum()) for boxes in truth]


@pytest.fixture
def task(spot_folder: Path, tmp_path: Path) -> Any:
    data = training_data([spot_folder])
    samples = prepare_samples(data.training, (40, 120), tmp_path / "cache")
    return StereoTask(samples, samples, Augmentation(), {}, lengths)


@pytest.mark.slow
def test_processes_prepare_what_threads_do_in_order(task: Any) -> None:
    by_threads = [batch.to("cpu") for batch in batches(task, CONFIGURATION, 2, 11, 2)]
    made = batches(task, CONFIGURATION, 2, 11, 3, processes=True)
    by_processes = [batch.to("cpu") for batch in made]
    assert len(by_threads) == len(by_processes) == 9
    for one, other in zip(by_threads, by_processes, strict=True):
        for name in ("left", "right", "left_projection", "right_projection"):
            assert torch.equal(getattr(one.stereo, name), getattr(other.stereo, name))
        assert torch.equal(one.disparity, other.disparity)
        assert one.targets == other.targets == lengths(other.truth)
    assert not torch.equal(by_threads[0].stereo.left, by_threads[1].stereo.left)


@pytest.mark.slow
def test_who_stops_early_leaves_no_process(task: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[Any] = []
    original = module.each_in_processes

    def spied(*arguments: Any, **options: Any) -> Any:
        started.append(original(*arguments, **options))
        return started[-1]

    monkeypatch.setattr(module, "each_in_processes", spied)
    made = batches(task, CONFIGURATION, 0, 1000, 2, processes=True)
    next(made)
    made.close()
    assert started[0].gi_frame is None


@pytest.mark.slow
def test_an_error_in_a_process_is_told(task: Any) -> None:
    (next(iter(task._training._places)).data.folder / "label_2" / "000000.txt").write_text("?")
    for path in (task._training._places[0].data.folder / "label_2").iterdir():
        path.write_text("Car ?")
    with pytest.raises(DataError, match="label_2"):
        next(batches(task, CONFIGURATION, 0, 4, 2, processes=True))


@pytest.mark.slow
def test_frames_reduced_by_processes_are_those_of_threads(
    spot_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = training_data([spot_folder]).training
    one = prepare_samples(frames, (40, 120), tmp_path / "threads")
    monkeypatch.setattr(stereo_samples, "_PROCESSES_PAY", 1)
    monkeypatch.setattr(stereo_samples, "_FRAMES_PAY", 1)
    told: list[int] = []
    other = prepare_samples(
        frames, (40, 120), tmp_path / "processes", on_progress=lambda done, _: told.append(done)
    )
    assert told == [1, 2, 3, 4, 5, 6]
    assert one.sizes == other.sizes
    for index in range(len(one)):
        assert (one[index].left == other[index].left).all()
        assert (one[index].right_disparity == other[index].right_disparity).all()
        assert (one[index].left_projection == other[index].left_projection).all()
