"""Detectors by name, and where their weights come from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.perception.detectors import make_detector
from avsec_gym.perception.detectors.detector import Detector, DifferentiableDetector
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.detectors.scan_obstacles import ScanObstacles
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import save_weights

LABEL = "Car 0.00 0 -1.58 587.01 173.33 614.12 200.12 1.65 1.67 3.64 -0.65 1.71 46.70 -1.59"


def frame(origin: Path | None) -> SensorFrame:
    return SensorFrame(
        "000007", Calibration(np.zeros((4, 3, 4)), np.eye(3), np.eye(4)[:3]), origin=origin
    )


@pytest.mark.parametrize(
    ("name", "network"), [("dsgn", DsgnDetector), ("stereo_rcnn", StereoRcnnDetector)]
)
def test_a_file_of_weights_makes_a_detector(name: str, network: type, tmp_path: Path) -> None:
    torch.manual_seed(3)
    own = network()
    path = tmp_path / "own.safetensors"
    save_weights(path, own.network, ModelCard(name, storage="float32"))
    made = make_detector({"name": name, "weights": str(path)})
    assert isinstance(made, DifferentiableDetector)
    assert made.name == name
    for one, other in zip(own.network.parameters(), made.network.parameters(), strict=True):  # type: ignore[attr-defined]
        assert torch.equal(one, other)


def test_missing_weights_tell_how_to_get_them(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"nowhere\.safetensors: There are no.*avsec train"):
        make_detector({"name": "dsgn", "weights": str(tmp_path / "nowhere.safetensors")})


def test_the_oracle_reads_the_labels_of_the_frames_own_folder(tmp_path: Path) -> None:
    (tmp_path / "label_2").mkdir()
    (tmp_path / "label_2" / "000007.txt").write_text(LABEL + "\n")
    oracle = make_detector("oracle")
    assert isinstance(oracle, Detector)
    assert oracle.detect(frame(tmp_path)).location[0].tolist() == [-0.65, 1.71, 46.7]
    with pytest.raises(DataError, match="does not come from a folder"):
        oracle.detect(frame(None))


def test_what_stands_up_in_a_scan_needs_no_file() -> None:
    made = make_detector("scan_obstacles")
    assert isinstance(made, Detector)
    assert made == ScanObstacles()
    assert make_detector({"name": "scan_obstacles", "ahead": 30.0}) == ScanObstacles(ahead=30.0)
    with pytest.raises(ConfigurationError, match="step takes a number"):
        make_detector({"name": "scan_obstacles", "step": 0.0})


def test_result_files_are_replayed_and_an_empty_one_is_nothing(tmp_path: Path) -> None:
    (tmp_path / "000007.txt").write_text(LABEL + " 0.8\n")
    replayed = make_detector({"name": "replayed", "detections": str(tmp_path)})
    assert replayed.detect(frame(None)).score.tolist() == [0.8]
    (tmp_path / "000007.txt").write_text("")
    assert len(replayed.detect(frame(None))) == 0
    # Without a file, a wrong folder would be a detector that is blind.
    (tmp_path / "000007.txt").rename(tmp_path / "000008.txt")
    with pytest.raises(DataError, match=r"(?s)000007\.txt.*has an empty file"):
        replayed.detect(frame(None))
    with pytest.raises(DataError, match="no such folder"):
        make_detector({"name": "replayed", "detections": str(tmp_path / "nowhere")})
