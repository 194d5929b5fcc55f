"""Frames to judge are of drives of their own, but where an attack has to last."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3 import recordings
from avsec_gym.experiments.chapter3.defence import defended_episodes
from avsec_gym.experiments.chapter3.defence.defended_episodes import DEFENCE
from avsec_gym.experiments.chapter3.experiments import (
    ADAPTIVE_ATTACKS,
    BELIEVED,
    FIVE_SENSORS,
    IDENTIFICATION,
    IMPACT,
    LOCALISATION,
    OBJECT_LEVEL,
    SENSITIVITY,
)
from avsec_gym.experiments.chapter3.recordings import (
    FITTED,
    JUDGED,
    SYSTEM,
    assets_in_words,
    check_parts,
    drives_inputs,
    frame_cells,
    procedural_drives,
    recordings_of,
    seed_of,
)
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.writing import write_raw_frame
from avsec_gym.rig import camera_rig
from avsec_gym.runs.experiment import Configuration, Experiment, with_defaults
from avsec_gym.validation.recordings import Recordings
from avsec_gym.world.export.manifest import world_fingerprint, write_manifest


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Recipes by the names that they are kept under; nothing is made."""
    known: dict[str, Any] = {}

    def cached(name: str, recipe: Any) -> Path:
        known[name] = recipe
        return Path(name)

    monkeypatch.setattr(recordings, "cached", cached)
    monkeypatch.setattr(recordings, "cache_folder", lambda: tmp_path)
    return known


def test_each_frame_is_of_its_own_drive(asked: dict[str, Any]) -> None:
    for part in (FITTED, JUDGED):
        procedural_drives(24, 3, part)
    fitted, judged = asked.values()
    assert fitted.settings["seed"] != judged.settings["seed"]
    for recipe in (fitted, judged):
        assert (len(recipe), recipe.settings["drive_frames"]) == (24, 1)


def test_a_defence_has_time(asked: dict[str, Any]) -> None:
    procedural_drives(24, 3, JUDGED)
    procedural_drives(24, 3, JUDGED, defended_episodes.DRIVE_FRAMES)
    short, long = asked.values()
    assert short.settings["drive_frames"] < long.settings["drive_frames"]


def test_a_larger_set_that_is_there_serves(asked: dict[str, Any], tmp_path: Path) -> None:
    def there(count: int, part: str, is_complete: bool = True, assets: str = "judge") -> None:
        name = f"chapter_3-{part}-3-{count}-1-{assets}-{world_fingerprint()}"
        (tmp_path / "suites" / name).mkdir(parents=True)
        manifest = {"format": 1, "complete": is_complete, "settings": {}, "files": {}}
        write_manifest(tmp_path / "suites" / name, manifest)

    there(24, FITTED)
    there(24, JUDGED, assets="train")
    there(20, JUDGED)
    there(100, JUDGED)
    there(50, JUDGED)
    there(30, JUDGED, is_complete=False)
    there(40, JUDGED)
    (damaged,) = tmp_path.glob("suites/chapter_3-judged-3-40-1-judge-*/*.json")
    damaged.write_text("{")
    for count in (24, 200):
        procedural_drives(count, 3, JUDGED)
    procedural_drives(24, 4, JUDGED)
    procedural_drives(24, 3, JUDGED, drive_frames=4)
    assert [len(recipe) for recipe in asked.values()] == [50, 200, 24, 24]


def test_fitted_and_judged_drives_share_no_assets_as_made(
    asked: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        recordings, "raw_recordings", lambda root, _: Recordings(Path(root), SYSTEM, (), {})
    )
    for options in ({}, {"fitted_assets": "all", "judged_assets": "train"}):
        for part in (FITTED, JUDGED):
            recordings_of(Configuration(PROCEDURAL, 24, 3, options), part)
    assert [recipe.settings["assets"] for recipe in asked.values()] == [
        *("train", "judge"), *("all", "train")
    ]  # fmt: skip
    with pytest.raises(ConfigurationError, match=r"judged_assets 'juge'.*judge"):
        recordings_of(Configuration(PROCEDURAL, 24, 3, {"judged_assets": "juge"}), JUDGED)


@pytest.mark.parametrize("experiment", [
    IDENTIFICATION, FIVE_SENSORS, ADAPTIVE_ATTACKS, OBJECT_LEVEL, IMPACT, BELIEVED, SENSITIVITY,
    LOCALISATION, DEFENCE,
])  # fmt: skip
def test_all_experiments_have_the_choice_of_assets(experiment: Experiment) -> None:
    asked = with_defaults(Configuration(PROCEDURAL, 24), [experiment])
    assert asked.options["judged_assets"] == "judge"
    [remark] = assets_in_words(asked)
    assert "judged are made of judging assets" in remark
    if experiment is not LOCALISATION:
        assert "fitted on are made of training assets" in remark


def test_real_drives_have_no_assets() -> None:
    asked = {"fitted_assets": "train", "judged_assets": "judge"}
    assert assets_in_words(Configuration("drives", options=asked | {"fit": "others"})) == []
    [remark] = assets_in_words(Configuration("drives", options=asked))
    assert "fitted on" in remark
    assert "judged" not in remark
    # A validator that was fitted elsewhere.
    [remark] = assets_in_words(
        Configuration(PROCEDURAL, options=asked | {"fitted_file": "own.json"})
    )
    assert "fitted on" not in remark
    # The options of a run from before there was a choice.
    assert assets_in_words(Configuration(PROCEDURAL, options={"fit": ""})) == []


def test_the_first_frames_of_many_are_the_frames_of_few(asked: dict[str, Any]) -> None:
    for count in (3, 7):
        procedural_drives(count, 3, JUDGED)
    few, many = asked.values()
    assert few.settings == many.settings


def test_new_drives_are_judged_by_what_others_were_fitted_on(
    asked: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        recordings, "raw_recordings", lambda root, _: Recordings(Path(root), SYSTEM, (), {})
    )

    def root(part: str, **options: Any) -> Path:
        return recordings_of(Configuration(PROCEDURAL, 24, 3, options), part).root

    own, judged = root(FITTED), root(JUDGED)
    assert own == procedural_drives(24, 3, FITTED)
    assert root(JUDGED, fit_seed=0, fit_limit=48) == judged
    assert root(FITTED, fit_seed=0, fit_limit=48) == procedural_drives(48, 0, FITTED)
    assert root(FITTED, fit_seed=3) == own


@pytest.mark.parametrize(
    ("options", "fitted"), [({}, 3), ({"fit_seed": -1}, 3), ({"fit_seed": 0}, 0)]
)
def test_the_attacks_to_fit_on_have_the_seed_of_their_drives(
    options: dict[str, int], fitted: int
) -> None:
    run = Configuration(PROCEDURAL, 24, 3, options)
    assert (seed_of(run, FITTED), seed_of(run, JUDGED)) == (fitted, 3)


def real_drives(root: Path, first: int, spread: float = 1.0) -> Path:
    """Two drives of two frames, whose cameras stand so many times 27 cm from each other."""
    places = [spread * offset for offset in (0.0, 0.54, -0.27, 0.27)]
    rig = camera_rig(places, focal_length=200.0, centre=(20.0, 10.0), size=(40, 20))
    day, image = root / "2011_09_26", np.zeros((20, 40, 3), np.uint8)
    frame = SensorFrame("", rig.calibration, dict.fromkeys(range(4), image), np.ones((1, 4), "f4"))
    write_raw_calibration(day, rig.calibration, image_size=rig.size)
    for drive in (first, first + 1):
        for number in range(2):
            write_raw_frame(day / f"{day.name}_drive_{drive:04d}_sync", number, frame)
    return day


def cells_of(judged: Path, fit: Path, limit: int | None = None) -> int:
    asked = Configuration(str(judged), limit, options={"fit": str(fit)})
    return len(frame_cells("work", asked, (FITTED, JUDGED)))


def test_nothing_is_judged_by_what_was_fitted_on_itself(tmp_path: Path) -> None:
    day, other = real_drives(tmp_path / "a", 1), real_drives(tmp_path / "b", 1)
    assert cells_of(day, other) == 8
    one, two = sorted(folder for folder in day.iterdir() if folder.is_dir())
    assert cells_of(one, two) == 4
    for judged, fit, both in ((day, day, "4 of the 4"), (one, day, "2 of"), (day, one, "2 of")):
        with pytest.raises(ConfigurationError, match=rf"{both}.*--options fit=FOLDER"):
            cells_of(judged, fit)
    # The first two frames of the day are of its first drive.
    assert cells_of(two, day, limit=2) == 4


def test_nothing_is_judged_by_what_was_fitted_on_another_rig(tmp_path: Path) -> None:
    near, far = real_drives(tmp_path / "a", 1, spread=0.2), real_drives(tmp_path / "b", 3)
    with pytest.raises(ConfigurationError, match=r"cameras that stand otherwise.*--options fit="):
        cells_of(near, far)


def test_nothing_is_rendered_for_a_rig_that_it_says_nothing_of(
    asked: dict[str, Any], tmp_path: Path
) -> None:
    near = Configuration(str(real_drives(tmp_path / "a", 1, spread=0.2)))
    for refused in (
        lambda: drives_inputs(near, (FITTED, JUDGED)),
        lambda: frame_cells("work", near, (FITTED, JUDGED)),
        lambda: check_parts(Configuration(PROCEDURAL, options={"fit": near.scenarios})),
    ):
        with pytest.raises(ConfigurationError, match="cameras that stand otherwise"):
            refused()
    assert not asked
