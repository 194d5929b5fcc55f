"""What is told of real frames, and what is not shown."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.json_rows import row_json
from avsec_gym.kitti.labels import parse_labels
from studies.perception.real_frames import compared, main

LABELS = parse_labels(
    """\
Car 0.00 0 -1.57 556.00 180.00 656.00 260.00 1.50 1.65 4.00 0.00 1.65 15.00 -1.57
Car 0.00 2 -1.66 690.00 178.00 750.00 225.00 1.50 1.65 4.00 3.50 1.65 25.00 -1.52
Pedestrian 0.00 0 0.10 300.00 170.00 330.00 260.00 1.80 0.60 0.80 -6.00 1.65 14.00 0.10
DontCare -1 -1 -10 10.00 170.00 60.00 200.00 -1 -1 -1 -1000 -1000 -1000 -10
""",
    "labels",
    keep_dont_care=True,
)


def test_right_missed_and_false_by_score() -> None:
    right = replace(LABELS[:1], location=LABELS.location[:1] * 1.02, score=np.array([0.8]))
    ghost = replace(
        right,
        location=np.array([[-9.0, 1.65, 30.0]]),
        box2d=np.array([[300.0, 170, 350, 210]]),
        score=np.array([0.5]),
    )
    found = Boxes3D.concatenate([ghost, right])
    result = row_json(compared(LABELS, found, 0.4))
    counts = [result[name] for name in ("to_find", "seen_in_image", "found", "missed")]
    assert (*counts, result["false_alarms"]) == (1, 1, 1, 0, 1)
    near, far = result["cars"]
    assert (near["ahead"], near["to_find"], near["score"], near["depth_error"]) == (
        15,
        True,
        0.8,
        0.3,
    )
    assert near["overlap"] > 0.8
    assert (far["ahead"], far["to_find"], far["score"], far["overlap"]) == (25, False, None, 0)
    assert [box["means"] for box in result["surest"]] == ["Car", None]
    assert [box["is_right"] for box in result["surest"]] == [True, False]
    strict = row_json(compared(LABELS, found, 0.9))
    assert (strict["found"], strict["missed"], strict["false_alarms"]) == (0, 1, 0)
    assert strict["cars"] == result["cars"], "told however unsure"


@pytest.mark.slow
def test_the_published_picture_holds_no_photograph(shared: Path, tmp_path: Path) -> None:
    import cv2

    points = tmp_path / "detectors.json"
    points.write_text('{"detectors": {"oracle": {"working_point": {"score": 0.7}}}}')
    paths = {name: tmp_path / name for name in ("real.json", "real.png", "pictures")}
    code = main(
        ["--kitti", str(shared / "kitti" / "object"), "--frames", "001570", "--detectors", "oracle",
         "--precision", str(points), "--json", str(paths["real.json"]),
         "--figure", str(paths["real.png"]), "--out", str(paths["pictures"])]
    )  # fmt: skip
    assert code == 0
    result = json.loads(paths["real.json"].read_text())["detectors"]["oracle"]
    assert result["least_score"] == 0.7
    frame = result["frames"]["001570"]
    assert (frame["to_find"], frame["found"], frame["false_alarms"]) == (1, 1, 0)
    assert len(frame["cars"]) == 2
    published, photographed = (
        cv2.imread(str(path)) for path in (paths["real.png"], paths["pictures"] / "001570.png")
    )
    colours = [len(np.unique(image.reshape(-1, 3), axis=0)) for image in (published, photographed)]
    assert colours[0] < 2_000 < 20_000 < colours[1]


def test_a_file_of_another_kind_is_refused(shared: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text("[]")
    assert main(["--kitti", str(shared / "kitti" / "object"), "--precision", str(other)]) == 1
