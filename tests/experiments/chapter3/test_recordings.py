"""Moments to judge are of drives of their own, but where an attack has to last."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from avsec_gym.experiments.chapter3 import defence, recordings
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED, procedural_drives


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Recipes by the names that they are kept under; nothing is made."""
    known: dict[str, Any] = {}

    def cached(name: str, recipe: Any) -> Path:
        known[name] = recipe
        return Path(name)

    monkeypatch.setattr(recordings, "cached", cached)
    return known


def test_each_moment_is_of_its_own_drive(asked: dict[str, Any]) -> None:
    for part in (FITTED, JUDGED):
        procedural_drives(24, 3, part)
    fitted, judged = asked.values()
    assert fitted.settings["seed"] != judged.settings["seed"]
    for recipe in (fitted, judged):
        assert (len(recipe), recipe.settings["drive_frames"]) == (24, 1)


def test_a_defence_has_time(asked: dict[str, Any]) -> None:
    procedural_drives(24, 3, JUDGED)
    procedural_drives(24, 3, JUDGED, defence.DRIVE_FRAMES)
    short, long = asked.values()
    assert short.settings["drive_frames"] < long.settings["drive_frames"]
