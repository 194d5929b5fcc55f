"""Accuracy of the two classifiers, as JSON."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.experiments.json_rows import row_of
from avsec_gym.metrics.intervals import wilson_interval
from studies.perception.classifier_accuracy import ClassifierAccuracy, counted, main
from studies.perception.page_classifiers import classifiers

STORED = Path(__file__).parents[3] / "studies/results"


def test_counts_and_interval() -> None:
    # The thesis' 524 of 533; the interval by hand: (p + z²/2n ± z sqrt(...)) / (1 + z²/n).
    truth, said = [True] * 500 + [False] * 33, [True] * 491 + [False] * 42
    result = counted(truth, said, list(map(str, range(533))))
    assert result.cases == 533
    assert result.accuracy == pytest.approx(524 / 533)
    assert result.interval == pytest.approx([0.9682, 0.9911], abs=2e-4)
    assert result.confusion == {
        "no_said_no": 33,
        "no_said_yes": 0,
        "yes_said_no": 9,
        "yes_said_yes": 491,
    }
    assert counted([], [], []).accuracy is None


def test_objects_of_one_scene_count_less() -> None:
    """Ten scenes of eight objects that are all right or all wrong say as much as ten objects."""
    right = np.repeat(np.arange(10) < 8, 8)
    found = counted([True] * 80, right.tolist(), np.repeat(np.arange(10), 8).astype(str).tolist())
    assert found.interval == pytest.approx(wilson_interval(8, 10))


def test_the_page_states_what_the_intervals_know() -> None:
    """Those of earlier results do not know scenes, and have no number of them."""
    stored = json.loads((STORED / "classifiers.json").read_text())
    stored["motion"]["world"]["with_neighbour"].pop("clusters", None)
    earlier = "\n".join(classifiers(row_of(ClassifierAccuracy, stored)))
    stored["motion"]["world"]["with_neighbour"]["clusters"] = 108
    later = "\n".join(classifiers(row_of(ClassifierAccuracy, stored)))
    assert "take objects for independent" in earlier
    assert "take objects for independent" not in later
    assert "widened by what the objects of one scene share" in later


def test_the_page_tells_both_kinds_of_errors_apart() -> None:
    stored = row_of(ClassifierAccuracy, json.loads((STORED / "classifiers.json").read_text()))
    assert stored.motion.world is not None
    confusion = stored.motion.world.accuracy.single_crop_of_the_same.confusion
    missed, moves = confusion["yes_said_no"], confusion["yes_said_no"] + confusion["yes_said_yes"]
    rows = [row.split(" | ") for row in classifiers(stored)]
    (row,) = [row for row in rows if row[0].startswith("| moves, by the single crop")]
    assert row[3] == f"{100 * missed / moves:.1f} ({missed} of {moves})"
    assert row[4].startswith(f"{100 * confusion['no_said_yes'] / (int(row[1]) - moves):.1f} (")


def test_nothing_to_judge_is_an_error() -> None:
    assert main([]) == 1
    assert main(["--kitti", "somewhere"]) == 1


@pytest.mark.slow
def test_real_frames_are_reported_apart(shared: Path, tmp_path: Path) -> None:
    out = tmp_path / "result.json"
    kitti, scenarios = shared / "kitti" / "object", shared / "safety_scenarios"
    arguments = ["--kitti", str(kitti), "--scenarios", str(scenarios), "--json", str(out)]
    assert main(arguments) == 0
    result = json.loads(out.read_text())
    flags = result["motion"]["real"]["flags_of_scenarios"]
    assert flags["frames"] == ["000001", "000002", "000004", "000005", "000006", "000107"]
    assert flags["with_neighbour"]["cases"] == 0, "these frames have no earlier images"
    assert flags["single_crop"]["cases"] == len(flags["objects"]) > 8
    listed = result["motion"]["real"]["static_by_list"]
    assert "000274" in listed["frames"]
    assert listed["with_neighbour"]["cases"] == 10
    roads = result["road_type"]["real"]
    assert roads["cases"] == 6
    # No list of road types has the frame without cars, which its folder calls a street.
    assert [row["frame"] for row in roads["frames"] if not row["has_cars"]] == ["000005"]
    assert [row["truth"] for row in roads["frames"] if row["frame"] == "000005"] == ["street"]
    assert "world" not in result["motion"]
