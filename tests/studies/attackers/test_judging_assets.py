"""Attackers learn from scenes of the training assets, and are judged in those of the others."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from avsec_gym.evaluation.contested import ChosenFrames
from avsec_gym.scenario.frame_scenes import check_frame_scenes
from studies.attackers import quiet_laser
from studies.attackers.arguments import arguments, given


def test_attackers_on_pixels_are_judged_on_judging_assets() -> None:
    options = arguments("Train.").parse_args([])
    training, testing = given(options.training), given(options.testing)
    assert training == {"source": "mixed", "split": "train", "assets": "train"}
    assert testing == {"source": "mixed", "split": "val", "assets": "judge"}
    for scenes in (training, testing):
        check_frame_scenes(scenes)
        assert json.loads(json.dumps(scenes)) == scenes


def test_a_laser_is_judged_on_judging_assets(monkeypatch: pytest.MonkeyPatch) -> None:
    made: dict[str, str] = {}

    def cached(name: str, recipe: ChosenFrames, **_: object) -> Path:
        made[name] = str(recipe.assets)
        return Path(name)

    def measured(_: object) -> None:
        raise SystemExit("scenes are made")

    monkeypatch.setattr(quiet_laser, "cached", cached)
    monkeypatch.setattr(quiet_laser, "frame_scenes_of", lambda what: what)
    monkeypatch.setattr(quiet_laser, "measured", measured)
    few = ["--scenes", "1", "--held-out", "1", "--clean-scenes", "1"]
    monkeypatch.setattr(sys, "argv", ["quiet_laser", *few])
    with pytest.raises(SystemExit, match="scenes are made"):
        quiet_laser.main()
    assert made == {
        "contested-2001-1-train": "train",
        "contested-2002-1-judge": "judge",
        "contested-2003-1-train": "train",
    }
