"""A part of another package enters the benchmark by its name; made twice, an entry is the same."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.benchmark import episodes, making, protocol
from avsec_gym.benchmark.scene_sets import Extent, FrozenSet, digest_of, frozen_sets
from avsec_gym.scenario.frame_scenes import FrameScenes, frame_scenes


class FramesOfFolder(FrozenSet):
    """A frozen set, but its frames are those of a folder."""

    folder: Path

    def frames(self, *, quick: bool = False, on_progress: Any = None) -> FrameScenes:
        return frame_scenes(self.folder)


@pytest.fixture
def few(data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The benchmark's frames are three, and the parts that entries meet are quick."""
    seed, numbers = frozen_sets()["all"].seed, (0, 1)
    frozen = FramesOfFolder("all", seed, numbers, None, Extent(2, 3), Extent(1, 3), "")
    digest = digest_of(frozen.layouts().labelled)
    object.__setattr__(frozen, "digest", digest)
    object.__setattr__(frozen, "folder", data)
    for module in (making, episodes):
        monkeypatch.setattr(module, "frozen_sets", lambda: {"all": frozen})
    monkeypatch.setattr(protocol, "DETECTORS", ("oracle", "stereo_clusters"))
    monkeypatch.setattr(protocol, "PERTURBATION", {"name": "random_noise", "strength": 8.0})
    monkeypatch.setattr(protocol, "OPTICAL", {"shift": ("oracle", {"name": "shifted_image"})})


@pytest.mark.parametrize(
    ("kind", "part", "settings"),
    [
        ("detector", "stereo_clusters", ["unattacked", "transferred", "patch"]),
        (
            "attack",
            '{"name": "shifted_image", "pixels": 5}',
            ["oracle", "oracle attacked", "stereo_clusters", "stereo_clusters attacked"],
        ),
        (
            "validator",
            "stereo_and_scan",
            ["unattacked", "unattacked validated", "shift", "shift validated"],
        ),
        ("planner", "lane_change", ["truth"]),
    ],
)
@pytest.mark.usefixtures("few")
def test_twice_the_same(
    avsec: Any, tmp_path: Path, kind: str, part: str, settings: list[str]
) -> None:
    words = ["benchmark", kind, part, "--workers", "0", "--json", "--out"]
    first = json.loads(avsec(*words, tmp_path / "one").stdout)
    assert [row["setting"] for row in first["rows"]] == settings
    assert first["name"] == (part if part.isidentifier() else json.loads(part)["name"])
    assert json.loads(avsec(*words, tmp_path / "two").stdout)["rows"] == first["rows"]
    assert json.loads((tmp_path / "one" / "entry.json").read_text()) == first
    if kind == "validator":
        alarms = {
            row["setting"]: row["alarms"]["count"] for row in first["rows"] if "alarms" in row
        }
        assert alarms == {"unattacked validated": 0, "shift validated": 3}


@pytest.mark.slow
def test_on_the_frozen_frames_themselves(avsec: Any, tmp_path: Path) -> None:
    words = ["benchmark", "detector", "stereo_clusters", "--quick", "--json", "--out"]
    found = json.loads(avsec(*words, tmp_path / "entry").stdout)
    extents = {name: frozen.quick.frames for name, frozen in frozen_sets().items()}
    assert {row["scenes"]: row["count"] for row in found["scenes"]} == extents
    assert found["quick"] is True
