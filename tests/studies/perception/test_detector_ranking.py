"""Detectors are ranked on assets that none of them was trained on."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

from avsec_gym.scenario.frame_scenes import check_frame_scenes
from studies.perception import detector_ranking
from studies.perception.detector_ranking import Ranked, compared


def test_detectors_are_ranked_on_judging_assets(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def ranked(detector: Any, scenarios: Any, episodes: int) -> Ranked:
        check_frame_scenes(scenarios)
        asked.append(scenarios)
        return Ranked({"safe_driving_rate": 0.0}, np.zeros(2, bool), ["a", "b"])

    monkeypatch.setattr(detector_ranking, "ranked", ranked)
    for words in ([], ["--contested"], ["--scenarios", "street"]):
        monkeypatch.setattr(sys, "argv", ["detector_ranking", "--detectors", "oracle", *words])
        detector_ranking.main()
    judging = {"source": "mixed", "assets": "judge"}
    contested = {"source": "mixed_contested", "assets": "judge"}
    assert asked == [judging, judging, contested, contested, "street", "street"]


def test_each_is_compared_with_the_one_behind_it_in_the_same_episodes() -> None:
    scenes = [f"{number // 2}" for number in range(40)]
    seeing, half = np.ones(40, bool), np.arange(40) % 4 > 0
    rows = compared(
        [
            Ranked({"detector": name, "safe_driving_rate": safe.mean()}, safe, scenes)
            for name, safe in (("blind", ~seeing), ("seeing", seeing), ("half", half))
        ]
    )
    assert [row["detector"] for row in rows] == ["seeing", "half", "blind"]
    assert [row.get("lead") for row in rows] == [0.25, 0.75, None]
    low, high = rows[0]["lead_interval"]
    assert 0.1 < low < 0.25 < high < 0.4
