"""The command from frames to JSON, pictures and the page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from avsec_gym.experiments.json_rows import row_of
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.labels import parse_labels
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.perception.weights.model_card import ModelCard
from avsec_gym.perception.weights.store import save_weights
from avsec_gym.rig import kitti_rig
from studies.perception.detector_precision import DetectorPrecision, main, named
from studies.perception.page import FILES, DetectorResults, page
from studies.perception.page import main as write_page
from studies.perception.weights_facts import weights_facts

LABELS = """\
Car 0.00 0 -1.57 556.00 180.00 656.00 260.00 1.50 1.65 4.00 0.00 1.65 15.00 -1.57
Car 0.00 1 -1.66 690.00 178.00 750.00 225.00 1.50 1.65 4.00 3.50 1.65 25.00 -1.52
Car 0.00 1 -1.42 450.00 178.00 515.00 222.00 1.50 1.65 4.00 -4.50 1.65 26.00 -1.59
Van 0.00 2 -1.57 600.00 172.00 640.00 200.00 2.00 1.80 5.00 0.50 1.65 40.00 -1.57
DontCare -1 -1 -10 10.00 170.00 60.00 200.00 -1 -1 -1 -1000 -1000 -1000 -10
"""


@pytest.fixture
def kitti(tmp_path: Path) -> Path:
    """Two frames of noise with labels."""
    root = tmp_path / "kitti"
    rng = np.random.default_rng(0)
    for number in range(2):
        images = {camera: rng.integers(0, 256, (375, 1242, 3), np.uint8) for camera in (2, 3)}
        frame = SensorFrame(f"{number:06d}", kitti_rig().calibration, images)
        labels = parse_labels(LABELS, "labels", keep_dont_care=True)
        write_object_frame(root / "training", frame, labels)
    return root


def run(kitti: Path, tmp_path: Path, *more: str) -> dict[str, Any]:
    out = tmp_path / "result.json"
    found = tmp_path / "found"
    arguments = ["--kitti", kitti, "--json", out, "--out", found, "--resamples", 10, "--timed", 1]
    assert main([*map(str, arguments), *more]) == 0
    result: dict[str, Any] = json.loads(out.read_text())
    return result


@pytest.mark.slow
def test_frames_become_figures_pictures_and_a_page(kitti: Path, tmp_path: Path) -> None:
    figures = tmp_path / "images"
    result = run(kitti, tmp_path, "--detectors", "oracle", "--figures", str(figures))
    assert result["data"]["frames"] == 2
    assert result["data"]["objects"] == 8
    assert result["data"]["cars"] == {"all": 6, "easy": 2, "moderate": 6, "hard": 6}
    oracle = result["detectors"]["oracle"]
    assert oracle["working_point"]["recall"] == oracle["working_point"]["precision"] == 1.0
    assert oracle["errors"][0]["overlap"]["0.7"] == 1.0
    assert oracle["weights"] is None
    assert [example["frame"] for example in result["examples"]] == ["000000", "000001", "000001"]
    assert result["examples"][0]["counts"]["oracle"] == {"found": 3, "missed": 0, "false_alarms": 0}
    names = {path.name for path in figures.iterdir()}
    pictures = {f"detections_{rank}.jpg" for rank in ("best", "median", "worst")}
    assert names == {"oracle_precision.png", *pictures}
    text = page(DetectorResults(row_of(DetectorPrecision, result)))
    assert "| `oracle` | all | 6 | 100.0 | 100.0 | 100.0 | 100.0 |" in text
    assert "No card states" in text
    assert "None" not in text
    assert "nan" not in text


def test_a_run_goes_on_with_what_was_detected(kitti: Path, tmp_path: Path) -> None:
    assert run(kitti, tmp_path, "--detectors", "oracle")["detectors"]["oracle"]["detections"] == 8
    (folder,) = (tmp_path / "found").iterdir()
    (folder / "000001.txt").write_text("")
    assert run(kitti, tmp_path, "--detectors", "oracle")["detectors"]["oracle"]["detections"] == 4
    manifest = {"format": 1, "complete": False, "settings": {}, "files": {}}
    (kitti / "manifest.json").write_text(json.dumps(manifest))
    again = run(kitti, tmp_path, "--detectors", "oracle")
    assert again["detectors"]["oracle"]["detections"] == 8, "of other data than before"


@pytest.mark.slow
def test_a_network_is_reported_with_its_card_beside_what_it_must(
    kitti: Path, tmp_path: Path
) -> None:
    torch.manual_seed(0)
    path = tmp_path / "own.safetensors"
    source = {"settings": {"suite": "mixed", "seed": 2}, "frames": 7, "fingerprint": "f"}
    card = ModelCard(
        "dsgn", data={"training": [source]}, training={"seed": 3, "batch": 2}, steps=1200, epochs=4,
        minutes=5.0, hardware="a machine", command="avsec train dsgn",
        metrics={"Car_3d_ap11": 12.0},
    )  # fmt: skip
    written = save_weights(path, DsgnDetector().network, card)
    result = run(kitti, tmp_path, "--detectors", f"dsgn={path}", "--limit", "1")
    one = result["detectors"]["dsgn"]
    assert one["weights"]["sha256"] == written.sha256
    assert one["weights"]["data"]["training"] == [
        {"suite": "mixed", "seed": 2, "frames": 7, "fingerprint": "f", "baseline": None}
    ]
    assert one["thesis"][1] == 52.98
    assert one["seconds"]["frames"] == 1
    assert one["seconds"]["median"] > 0
    result["data"] |= {"suite": "mixed", "seed": 2}
    text = page(DetectorResults(row_of(DetectorPrecision, result)))
    assert "**Not held out" in text
    assert "`dsgn` misses what it must and misses its goal by 45.0" in text
    assert "7 frames of `mixed`, seed 2 | – | 4; 1,200 | 3 | AP11 in space 12.0" in text


def test_other_parts_of_the_page(kitti: Path, tmp_path: Path) -> None:
    run(kitti, tmp_path, "--detectors", "oracle")
    (tmp_path / "result.json").rename(tmp_path / FILES["detectors"])
    (tmp_path / FILES["ranking"]).write_text(
        '[{"detector": "oracle", "safe_driving_rate": 0.75, "interval": [0.5, 0.9],'
        ' "collisions": 1, "unplanned": 2, "found": 1.0}]'
    )
    (tmp_path / FILES["parity"]).write_text('{"dsgn": {"depth": 1e-6, "cls": 2e-5}}')
    (tmp_path / FILES["seconds"]).write_text(
        '{"threads": 2, "frames": 8, "dsgn": {"parameters": 9,'
        ' "detect": 0.25, "pixel_gradient": 0.5, "training_per_image": 0.4}}'
    )
    assert write_page(["--results", str(tmp_path), "--json", str(tmp_path / "said.json")]) == 0
    text = (tmp_path / "detectors.md").read_text()
    assert "| `oracle` | 75.0 (50.0 to 90.0) | – | 1 | 2 | 100.0 |" in text
    assert "| `dsgn` | 2 | 2.0e-05 |" in text
    assert "| `dsgn` | 9 | 0.25 | 0.50 | 0.40 |" in text
    assert "Disparity" not in text


def test_bad_input_is_told(kitti: Path, tmp_path: Path) -> None:
    assert main(["--kitti", str(tmp_path / "nowhere")]) == 1
    assert main(["--kitti", str(kitti), "--detectors", "unheard_of", "--out", str(tmp_path)]) == 1
    assert main(["--kitti", str(kitti), "--limit", "0"]) == 1
    assert write_page(["--results", str(tmp_path)]) == 1
    (tmp_path / FILES["detectors"]).write_text("{")
    assert write_page(["--results", str(tmp_path)]) == 1


def test_weights_of_ones_own_are_named() -> None:
    assert named("dsgn") == {"name": "dsgn"}
    assert named("dsgn=a=b.st") == {"name": "dsgn", "weights": "a=b.st"}
    assert weights_facts(None) is None


def test_frames_to_train_on_are_told_by_the_distance_of_their_cameras() -> None:
    facts = weights_facts(shipped_weights("psmnet_small"))
    assert facts is not None
    narrow = next(folder for folder in facts.data.training if folder.baseline == 0.29)
    assert (narrow.suite, narrow.frames) == ("mixed", 120)
    # KITTI's pair of colour cameras.
    assert 0.53 < (facts.data.validation[0].baseline or 0.0) < 0.54
