"""What perfect detections reach: the closed form against the evaluator, scoring the labels."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.kitti import KittiObject
from avsec_gym.kitti.labels import DONT_CARE, write_detections, write_labels
from avsec_gym.metrics.average_precision import average_precision
from avsec_gym.metrics.average_precision_curves import FEWEST_LABELS, best_average_precisions


def cars(count: int, height: float = 60.0) -> Boxes3D:
    """A row of cars that do not overlap."""
    left = 100.0 * np.arange(count)
    return Boxes3D(
        np.column_stack([10.0 * np.arange(count), np.full(count, 1.65), np.full(count, 20.0)]),
        np.tile([1.5, 1.6, 4.0], (count, 1)),
        np.zeros(count),
        np.ones(count),
        np.full(count, "Car"),
        box2d=np.column_stack([left, np.zeros(count), left + 80, np.full(count, height)]),
        truncation=np.zeros(count),
        occlusion=np.zeros(count),
        alpha=np.zeros(count),
    )


@pytest.mark.parametrize("distinct", [False, True])
def test_the_labels_themselves_reach_exactly_the_ceiling(distinct: bool) -> None:
    draw = np.random.default_rng(0)
    for count in [*range(1, 90), 127, 400, 1000]:
        truth = cars(count)
        score = draw.permutation(count) / count if distinct else np.ones(count)
        result = average_precision([truth], [replace(truth, score=score)], classes=("Car",))
        assert result.labels.tolist() == [[count] * 3]
        for level in range(3):
            for metric in range(4):
                found = [result.ap11[0, metric, level], result.ap40[0, metric, level]]
                assert found == pytest.approx(list(best_average_precisions(count)))
            assert result.ceiling[0, level].tolist() == list(best_average_precisions(count))


def test_known_ceilings() -> None:
    assert best_average_precisions(0) == (0.0, 0.0)
    assert best_average_precisions(18) == pytest.approx((100 * 5 / 11, 42.5))
    assert best_average_precisions(14)[0] == pytest.approx(36.4, abs=0.05)
    below = [best_average_precisions(count) for count in range(1, FEWEST_LABELS)]
    assert all(max(pair) < 100 for pair in below)
    for count in range(FEWEST_LABELS, 3000):
        assert best_average_precisions(count) == pytest.approx((100, 100))


def test_on_real_labels(shared: Path) -> None:
    data = KittiObject(shared / "kitti" / "object")
    ids = data.ids(having=("label_2",))
    for first, frames in ((0, 4), (4, 12), (30, 60)):
        truth = [data.labels(id, keep_dont_care=True) for id in ids[first : first + frames]]
        found = [boxes[boxes.category != DONT_CARE] for boxes in truth]
        result = average_precision(truth, found)
        for points, values in enumerate((result.ap11, result.ap40)):
            for metric in range(3):
                np.testing.assert_allclose(values[:, metric], result.ceiling[..., points])


def test_the_command_states_it_and_warns(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for folder, count in (("few", 18), ("enough", FEWEST_LABELS)):
        write_labels(tmp_path / folder / "training" / "label_2" / "000000.txt", cars(count))
        write_detections(tmp_path / folder / "results" / "000000.txt", cars(count))
        root = tmp_path / folder
        command = ["ap", "--kitti", str(root), "--detections", str(root / "results")]
        assert run([*command, "--json", "--out", str(root / "report.json")]) == 0
        shown = capsys.readouterr()
        car = json.loads(shown.out)["Car"]
        assert car["labels"] == [count] * 3
        assert car["ceiling"]["ap11"] == car["3d"]["ap11"]
        assert car["ceiling"]["ap40"] == car["3d"]["ap40"]
        report = json.loads((root / "report.json").read_text())
        assert report["average_precision"]["Car"]["ceiling"] == car["ceiling"]
        warned = "Car: easy 18, moderate 18, hard 18" in " ".join(shown.err.split())
        assert warned is (count == 18)
        assert run(command) == 0
        table = capsys.readouterr().out
        assert "ceiling" in table
        assert "labels that count" in table
        assert ("45.5" in table) is (count == 18)
