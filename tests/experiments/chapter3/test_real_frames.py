"""Attacks on a real frame, by thresholds that are given."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.real_frames import noticed, run
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import fitted_on
from avsec_gym.validation.thresholds import ThresholdTable


def test_light_into_real_cameras_is_noticed(shared: Path) -> None:
    frame = KittiObject(shared / "kitti" / "object").frame("000107")
    depth = PairDepth("sgbm")
    on = fitted_on(LIDAR_AND_TWO_CAMERAS, depth, frame.calibration, {"made": "up"})
    usual = ThresholdTable(on, np.array([[[0.25, 0.3, 0.05, 0.01]]]))
    found = noticed(frame, usual, depth, 0.01, draws=2)
    assert found["false_alarm"] == {"any": False, "error": False}
    assert 0 < found["clean"]["error"] < 0.25
    assert list(found["cases"]) == ["S0", "S1", "S0+S1", "S2", "S0+S2", "S1+S2", "S0+S1+S2"]
    for case in ("S1", "S2", "S0+S1+S2"):
        assert found["cases"][case]["any"]["count"] == 2
    # Whoever is beyond no threshold at all notices nothing.
    deaf = ThresholdTable(on, np.ones((1, 1, 4)))
    assert not any(
        one["any"]["count"] for one in noticed(frame, deaf, depth, 0.01, 1)["cases"].values()
    )


def test_no_draws() -> None:
    with pytest.raises(ConfigurationError, match="--draws"):
        run(Namespace(draws=0, kitti=Path("nowhere"), rate=0.01))
