"""A part of another package enters the benchmark by its name; made twice, an entry is the same."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.benchmark import (
    entry_sets,
    episodes,
    loop_drives,
    loop_protocol,
    making,
    protocol,
)
from avsec_gym.benchmark.loop_scenes import CLOSED_LOOP, digest_of_drives, frozen_drives
from avsec_gym.benchmark.scene_sets import Extent, FrozenSet, digest_of, frozen_sets
from avsec_gym.closed_loop.error_model.model import ErrorModel, write_error_model
from avsec_gym.runs.fingerprints import fingerprint
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
    for module in (making, entry_sets, episodes):
        monkeypatch.setattr(module, "frozen_sets", lambda: {"all": frozen})
    first = next(iter(frozen_drives().ways))
    drives = replace(frozen_drives(), ways={first: frozen_drives().ways[first]})
    digest = digest_of_drives([drives.scenes.scene(first)])
    drives = replace(drives, digest=digest, quick_digest=digest)
    for module in (entry_sets, loop_drives, loop_protocol):
        monkeypatch.setattr(module, "frozen_drives", lambda: drives)
    for module in (protocol, loop_protocol):
        monkeypatch.setattr(module, "DETECTORS", ("oracle", "stereo_clusters"))
    for name in ("PERTURBATION", "STRONGER"):
        monkeypatch.setattr(protocol, name, {"name": "random_noise", "strength": 8.0})
    monkeypatch.setattr(protocol, "OPTICAL", {"shift": ("oracle", {"name": "shifted_image"})})


@pytest.mark.slow
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
    second = json.loads(avsec(*words, tmp_path / "two").stdout)
    assert second["rows"] == first["rows"]
    assert second["drives"] == first["drives"]
    # A plug-in's optical attack takes no gradient; a planner and a validator are attacked by none.
    assert first["white_box"] is (False if kind in ("detector", "attack") else None)
    driven = [row["setting"] for row in first["drives"]]
    assert driven == (["truth", "dsgn", "dsgn_patch"] if kind == "planner" else [])
    assert [*first["skipped"]] == ([CLOSED_LOOP] if kind in ("detector", "attack") else [])
    assert json.loads((tmp_path / "one" / "entry.json").read_text()) == first
    if kind == "validator":
        alarms = {
            row["setting"]: row["alarms"]["count"] for row in first["rows"] if "alarms" in row
        }
        assert alarms == {"unattacked validated": 0, "shift validated": 3}


@pytest.mark.usefixtures("few")
def test_a_detector_and_an_attack_drive_on_by_error_models(avsec: Any, tmp_path: Path) -> None:
    """The detector under the attack, as `avsec error-model fit` would have filed both."""
    shift = {"name": "shifted_image", "pixels": 5}
    cards = [{"detector": "stereo_clusters", "attack": attack} for attack in ("", shift)]
    files = [tmp_path / "clean.json", tmp_path / "shifted.json"]
    for path, card in zip(files, cards, strict=True):
        write_error_model(path, ErrorModel(card=card))
    words = ["--workers", "0", "--json", "--error-model", *files, "--out"]
    found = [
        json.loads(avsec("benchmark", kind, part, *words, tmp_path / kind).stdout)["drives"]
        for kind, part in (("detector", "stereo_clusters"), ("attack", json.dumps(shift)))
    ]
    assert [[row["setting"] for row in rows] for rows in found] == [
        ["unattacked", "shifted_image"], ["stereo_clusters", "stereo_clusters attacked"],
    ]  # fmt: skip
    assert {row["error_model"] for rows in found for row in rows} == {*map(fingerprint, files)}


@pytest.mark.slow
def test_on_the_frozen_frames_themselves(avsec: Any, tmp_path: Path) -> None:
    words = ["benchmark", "detector", "stereo_clusters", "--quick", "--json", "--out"]
    found = json.loads(avsec(*words, tmp_path / "entry").stdout)
    extents = {name: frozen.quick.frames for name, frozen in frozen_sets().items()}
    assert {row["scenes"]: row["count"] for row in found["scenes"]} == extents
    assert found["quick"] is True
