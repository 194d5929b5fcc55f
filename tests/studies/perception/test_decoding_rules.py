"""Rules of decoding are undone one at a time, and scored frame by frame."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.labels import parse_labels
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.rig import kitti_rig
from studies.perception import decoding_rules
from studies.perception.decoding_rules import RULES, DecodingRules, main, rules_of_decoding

LABELS = "Car 0.00 0 -1.57 556.00 180.00 656.00 260.00 1.50 1.65 4.00 0.00 1.65 15.00 -1.57\n"


def test_each_undone_rule_changes_what_it_names_and_nothing_else() -> None:
    for name, rules in RULES.items():
        shipped: Any = decoding_rules._with(name, {})
        for words, changes in rules.items():
            undone = decoding_rules._with(name, changes)
            for what in ("rule", "alignment"):
                before, after = (
                    asdict(getattr(each, what, shipped.rule)) for each in (shipped, undone)
                )
                differing = {key for key in before if before[key] != after[key]}
                assert differing == set(changes.get(what, {})), (name, words)


def test_a_rule_that_loses_all_cars_costs_all_precision(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    truth = parse_labels(LABELS, "labels", keep_dont_care=True)
    for number in range(2):
        images = {camera: np.zeros((375, 1242, 3), np.uint8) for camera in (2, 3)}
        frame = SensorFrame(f"{number:06d}", kitti_rig().calibration, images)
        write_object_frame(tmp_path / "kitti" / "training", frame, truth)

    class Fake:
        def __init__(self, name: str, changes: dict[str, Any]) -> None:
            self.found = Boxes3D.empty() if changes else truth

        def detect(self, frame: SensorFrame) -> Boxes3D:
            return self.found

    monkeypatch.setattr(decoding_rules, "_with", Fake)
    file = tmp_path / "rules.json"
    arguments = ["--kitti", tmp_path / "kitti", "--json", file, "--resamples", 5]
    assert main([*map(str, arguments)]) == 0
    result = row_of(DecodingRules, json.loads(file.read_text()))
    rows = [row for row in result.rows if row.detector == "dsgn"]
    assert [row.rule for row in rows] == ["as shipped", *RULES["dsgn"]]
    first = rows[0].precision["0.7"].value
    assert first is not None
    assert first > 0
    assert all(row.difference["0.7"].value == -first for row in rows[1:])
    text = "\n".join(rules_of_decoding(result))
    assert "| `dsgn` | no votes | 0.0" in text
