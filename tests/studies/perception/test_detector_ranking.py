"""Detectors are ranked on assets that none of them was trained on."""

from __future__ import annotations

import sys
from typing import Any

import pytest

from avsec_gym.scenario.frame_scenes import check_frame_scenes
from studies.perception import detector_ranking


def test_detectors_are_ranked_on_judging_assets(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def ranked(detector: Any, scenarios: Any, episodes: int) -> dict[str, Any]:
        check_frame_scenes(scenarios)
        asked.append(scenarios)
        return {"safe_driving_rate": 0.0}

    monkeypatch.setattr(detector_ranking, "ranked", ranked)
    for words in ([], ["--scenarios", "street"]):
        monkeypatch.setattr(sys, "argv", ["detector_ranking", "--detectors", "oracle", *words])
        detector_ranking.main()
    judging = {"source": "mixed", "assets": "judge"}
    assert asked == [judging, judging, "street", "street"]
