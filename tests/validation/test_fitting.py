"""Fits to clean frames: what is measured, what is left out, and how a stopped fit goes on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.evidence import gather_evidence
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitting import (
    CleanFrames,
    check_samples,
    fit_likelihood_model,
    fit_threshold_table,
)
from avsec_gym.validation.likelihood.likelihood_of_clean import evidence_of_all_states
from avsec_gym.validation.recordings import RecordedFrame

SYSTEM = SensorSystem((LIDAR, 1, 0))
WallOf = Callable[[int], SensorFrame]


@pytest.fixture
def clean(wall_of: WallOf) -> CleanFrames:
    frames = [RecordedFrame(str(seed), partial(wall_of, seed)) for seed in range(4)]
    return CleanFrames(frames, SYSTEM, PairDepth(), {"walls": "of dots"})


def with_a_broken_one(clean: CleanFrames) -> CleanFrames:
    """The second frame lacks camera 1."""

    def broken() -> SensorFrame:
        frame = clean.frames[1].frame()
        return replace(frame, images={0: frame.image(0)})

    first, _, *others = clean.frames
    return replace(clean, frames=[first, RecordedFrame("1", broken), *others])


def test_thresholds_are_measured_frame_by_frame(clean: CleanFrames, wall_of: WallOf) -> None:
    progress = []
    table = fit_threshold_table(clean, on_progress=lambda *done: progress.append(done))
    assert len(table) == 4
    errors = DisparityErrors(DisparityMaps(wall_of(3), SYSTEM))
    expected = [errors[triple].shares for triple in SYSTEM.triples]
    np.testing.assert_array_equal(table.shares[3], expected)
    assert table.on.system == SYSTEM
    assert table.on.data == {"walls": "of dots", "frames": 4}
    assert progress == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_a_stopped_fit_goes_on_with_the_next_frame(clean: CleanFrames, tmp_path: Path) -> None:
    samples, read = tmp_path / "samples.jsonl", []

    def stopped(done: int, _: int) -> None:
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fit_threshold_table(clean, samples=samples, on_progress=stopped)
    progress = lambda *done: read.append(done)  # noqa: E731
    again = fit_threshold_table(clean, samples=samples, on_progress=progress)
    assert read == [(1, 1)]
    np.testing.assert_array_equal(again.shares, fit_threshold_table(clean).shares)


@pytest.mark.parametrize(
    "measured",
    [
        [[0.1, 0.2]],
        [[0.1, 0.2], [0.1, 0.2], [0.1, 0.2]],
        [[0.1, 0.2], [0.1]],
        [[0.1, 0.2], [0.1, 0.2, 0.3]],
        [[0.1, 0.2], [0.1, 1.01]],
        [[0.1, 0.2], [0.1, -0.01]],
        [[0.1, 0.2], [0.1, float("nan")]],
    ],
)
def test_a_kept_row_of_another_shape_or_beyond_a_share_is_refused(
    measured: list[list[float]], tmp_path: Path
) -> None:
    check_samples({"7": {"measured": [[0.0, 1.0], [0.1, 0.2]]}}, (2, 2), None)
    with pytest.raises(DataError, match="'7' does not hold 2 x 2 shares") as caught:
        check_samples({"7": {"measured": measured}}, (2, 2), tmp_path)
    assert caught.value.path == str(tmp_path)


def test_a_broken_frame_is_an_error_or_left_out(clean: CleanFrames) -> None:
    frames = with_a_broken_one(clean)
    with pytest.raises(DataError, match="1"):
        fit_threshold_table(frames)
    table = fit_threshold_table(replace(frames, leaves_out_broken=True))
    assert len(table) == 3
    assert table.on.data["frames"] == 3
    assert list(table.on.data["left_out"]) == ["1"]
    np.testing.assert_array_equal(table.shares, fit_threshold_table(clean).shares[[0, 2, 3]])


def test_nothing_to_fit_on_is_refused_with_the_reason(clean: CleanFrames) -> None:
    with pytest.raises(ConfigurationError, match=r"no clean frames to fit on$"):
        fit_threshold_table(replace(clean, frames=[]))
    broken = with_a_broken_one(clean)
    only = replace(broken, frames=broken.frames[1:2], leaves_out_broken=True)
    with pytest.raises(ConfigurationError, match=r"to fit on: .*image"):
        fit_threshold_table(only)


def test_attacks_of_a_likelihood_do_not_depend_on_what_was_measured_before(
    clean: CleanFrames, wall_of: WallOf, tmp_path: Path
) -> None:
    """A frame's number, of which its attacks are drawn, counts the frames that are left out."""
    samples = tmp_path / "samples.jsonl"
    frames = replace(with_a_broken_one(clean), leaves_out_broken=True)
    with pytest.raises(ConfigurationError, match="10 frames"):
        fit_likelihood_model(frames, seed=5, samples=samples)
    lines = samples.read_text().splitlines(keepends=True)
    # Stopped after two frames: the third has the attacks that it had.
    samples.write_text("".join(lines[:2]))
    with pytest.raises(ConfigurationError, match="10 frames"):
        fit_likelihood_model(frames, seed=5, samples=samples)
    assert samples.read_text().splitlines(keepends=True) == lines
    expected = evidence_of_all_states(wall_of(3), SYSTEM, PairDepth(), (5, 3))
    assert str(expected.tolist()) in lines[2]


def test_a_likelihood_is_fitted_to_clean_and_attacked_frames(wall_of: WallOf) -> None:
    frames = [RecordedFrame(str(seed), partial(wall_of, seed)) for seed in range(10)]
    model = fit_likelihood_model(CleanFrames(frames, SYSTEM, PairDepth()), seed=0)
    errors = DisparityErrors(DisparityMaps(wall_of(2), SYSTEM))
    assert model.on.data == {"frames": 10}
    assert len(model.clean_scores) == 10
    assert not model.decode(gather_evidence(errors)[None], 0.0).alarms[0]
