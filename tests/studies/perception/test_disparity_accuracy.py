"""The comparison on pairs whose truth is known."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.map_files import write_disparity
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.perception.depth.sgbm import SemiGlobalMatching
from avsec_gym.rig import kitti_rig
from studies.perception.disparity_accuracy import (
    MatchedPair,
    ReducedMatching,
    main,
    measured,
    real_pairs,
    world_pairs,
)


def shifted(disparity: int) -> SensorFrame:
    """A pair of one texture, the same disparity everywhere."""
    rng = np.random.default_rng(0)
    coarse = rng.integers(0, 256, (24, 90, 1)).astype(np.uint8)
    wide = np.repeat(coarse.repeat(5, axis=0).repeat(5, axis=1), 3, axis=2)
    images = {2: wide[:, : 450 - disparity], 3: wide[:, disparity:]}
    return SensorFrame("000000", kitti_rig().calibration, images)


def test_reduced_matching_speaks_of_the_cameras_pixels() -> None:
    frame = shifted(20)
    found = ReducedMatching((60, 215), 32).disparity(frame)
    assert found.values.shape == (120, 430)
    inside = found.values[:, 80:]
    assert np.isfinite(inside).mean() > 0.9
    assert np.nanmedian(np.abs(inside - 20)) < 0.5


def test_estimators_are_compared_on_the_same_pairs(tmp_path: Path) -> None:
    frame = shifted(20)
    truth = np.full((120, 430), 20, np.float32)
    write_object_frame(tmp_path / "training", frame)
    write_disparity(tmp_path / "training" / "disparity_2" / "000000.png", truth)
    (pair,) = world_pairs(tmp_path)
    assert np.array_equal(pair.truth, truth)
    result = measured(
        {"sgbm": SemiGlobalMatching(disparities=32)}, [pair, MatchedPair(frame, truth)]
    )
    assert result.pairs == 2
    sgbm = result.estimators["sgbm"]
    assert (sgbm.rates.found.end_point_error.value or 9.0) < 0.2
    assert 0.8 < (sgbm.rates.density.value or 0.0) < 1.0
    assert sgbm.seconds > 0


def test_estimators_are_compared_where_matching_finds_something() -> None:
    frame, half = shifted(20), MatchedPair(shifted(20), np.full((120, 430), 20, np.float32))

    class FarOffAtHoles:
        """Right where semi-global matching finds something, and nowhere else."""

        name = "far_off_at_holes"

        def disparity(self, frame: SensorFrame) -> DisparityMap:
            found = SemiGlobalMatching(disparities=32).disparity(frame).values
            return DisparityMap(np.where(np.isfinite(found), np.float32(20), np.float32(90)), 1.0)

    class Lower:
        """Off by ten pixels in the left half."""

        name = "lower"

        def disparity(self, frame: SensorFrame) -> DisparityMap:
            values = np.full((120, 430), 20, np.float32)
            values[:, :215] = 30
            return DisparityMap(values, 1.0)

    estimators = {"sgbm": SemiGlobalMatching(disparities=32), "a": FarOffAtHoles(), "b": Lower()}
    rows = measured(estimators, [half, half], resamples=20).estimators
    density, wrong = rows["sgbm"].rates.density.value, rows["sgbm"].where_matched.off_3px.value
    assert density is not None
    assert wrong is not None
    assert wrong == rows["sgbm"].rates.found.off_3px.value
    assert rows["sgbm"].more_wrong.value == 0
    assert rows["a"].where_matched.off_3px.value == 0
    assert rows["a"].rates.all.off_3px.value == pytest.approx(1 - density, abs=1e-4)
    assert rows["a"].more_wrong.value == pytest.approx(-wrong, abs=1e-4)
    # Nothing is found at the left border, so that of what is found less than half lies there.
    found = np.isfinite(estimators["sgbm"].disparity(frame).values)
    share = found[:, :215].sum() / found.sum()
    assert rows["b"].where_matched.off_3px.value == pytest.approx(share, abs=1e-4)
    assert rows["b"].more_wrong.value == pytest.approx(share - wrong, abs=1e-4)
    assert rows["b"].more_wrong.interval is not None


def test_real_pairs_are_found_beside_the_object_benchmark(shared: Path) -> None:
    pairs = list(real_pairs(shared / "kitti" / "object"))
    assert [pair.frame.id for pair in pairs] == ["stereo2012 000000_10", "stereo2015 000000_10"]
    sgbm = measured({"sgbm": SemiGlobalMatching()}, pairs[1:]).estimators["sgbm"].rates
    found, every = sgbm.found.d1.value, sgbm.all.d1.value
    assert found is not None
    assert every is not None
    assert found < every < 0.3


def test_nothing_to_judge_is_an_error(tmp_path: Path) -> None:
    assert main([]) == 1
    missing = tmp_path / "weights.safetensors"
    assert main(["--world", str(tmp_path), "--weights", str(missing)]) == 1


@pytest.mark.slow
def test_the_command(tmp_path: Path, shared: Path) -> None:
    import torch

    from avsec_gym.perception.depth.psmnet_depth import PsmNetDepth
    from avsec_gym.perception.weights.model_card import ModelCard
    from avsec_gym.perception.weights.store import save_weights

    torch.manual_seed(0)
    weights, out = tmp_path / "psmnet.safetensors", tmp_path / "result.json"
    save_weights(weights, PsmNetDepth().network, ModelCard("psmnet"))
    kitti = shared / "kitti" / "object"
    assert main(["--kitti", str(kitti), "--weights", str(weights), "--json", str(out)]) == 0
    result = json.loads(out.read_text())
    assert result["input_sizes"]["psmnet_small"] == [208, 688]
    for pair in result["real"].values():
        assert set(pair["estimators"]) == {"psmnet_small", "psmnet_medium", "sgbm_reduced", "sgbm"}
        assert pair["estimators"]["psmnet_medium"]["density"]["value"] == 1.0
