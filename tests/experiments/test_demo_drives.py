"""The scene of the demo in which the car drives on: found by rule, driven under each setting."""

from __future__ import annotations

import base64
import io
import os
from pathlib import Path
from typing import Any

import pytest
from PIL import Image, ImageSequence

from avsec_gym.closed_loop.drive_record import Outcome
from avsec_gym.drawing.page_figure import Figure
from avsec_gym.drives.drive_folder import FILMS, ROWS
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.errors import DataError
from avsec_gym.experiments.demo import drive_on as demo
from avsec_gym.experiments.demo import telling_drive as search
from avsec_gym.experiments.demo.drive_on import are_demo_drives, drive_on, last_drive
from avsec_gym.experiments.demo.drive_section import (
    beside_in_words,
    driven_rows,
    driven_section,
    in_words,
)
from avsec_gym.experiments.demo.telling_drive import (
    TELLING,
    PassedOver,
    TellingDrive,
    contested_drive,
    telling_drive,
)

SCENES = {"source": "drives", "seed": 0, "count": 20}


@pytest.fixture
def without_eyes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cars that see all, or nothing, so that nothing is rendered."""
    sees = {demo.UNATTACKED: "truth", demo.ATTACKED: "blind", demo.DEFENDED: "truth"}
    settings = tuple(DriveSetting(name, {"perception": what}) for name, what in sees.items())
    monkeypatch.setattr(demo, "SETTINGS", settings)
    control = DriveSetting(demo.CONTROL, {"perception": "truth"})
    monkeypatch.setattr(demo, "CONTROL_SETTING", control)


@pytest.mark.slow
def test_the_scene_is_the_first_one_in_which_it_matters_what_the_car_sees() -> None:
    found = contested_drive(SCENES)

    def ends(perception: str, scene: str, seed: int) -> dict[str, Any]:
        environment = DriveSetting(perception, {"perception": perception}).environment(SCENES)
        return drive(environment, DriveTask(perception, scene, "straight", seed)).row

    number = int(found.rpartition("-")[2])
    assert ends("blind", found, number)["at_fault"]
    assert ends("truth", found, number)["outcome"] == "goal"
    for earlier in range(number):
        scene = f"drive-{earlier:06d}"
        is_blamed = ends("blind", scene, earlier)["at_fault"]
        assert not is_blamed or ends("truth", scene, earlier)["outcome"] != "goal"


@pytest.mark.slow
@pytest.mark.skipif("DEMO_SEARCH" not in os.environ, reason="minutes: set DEMO_SEARCH to look")
def test_the_light_decides_the_scene_that_is_shown() -> None:
    """Takes 12 minutes: 1.5 s of a processor for each scene, a minute for a contested one."""
    scenarios = {"source": "drives", "seed": 0, "count": search.MOST_SCENES}
    assert telling_drive(scenarios, 0, *demo.SETTINGS[:2]) == TELLING[0]


@pytest.mark.usefixtures("without_eyes")
def test_a_scene_is_telling_if_the_unattacked_car_is_safe_in_it_and_the_attacked_one_not() -> None:
    found = telling_drive(SCENES, 0, *demo.SETTINGS[:2])
    number = int(found.scene.rpartition("-")[2])
    assert found == TellingDrive(contested_drive(SCENES), PassedOver(number))
    with pytest.raises(DataError, match="the light decides none"):
        telling_drive(SCENES, 0, demo.SETTINGS[0], demo.SETTINGS[2])


def test_what_a_search_passes_over_is_counted_by_the_condition_that_it_fails(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    goal, crash = (
        {"outcome": "goal", "at_fault": False},
        {"outcome": "collision", "at_fault": True},
    )
    ends = {3: (crash,), 7: (goal, goal), 9: (crash,), 12: (goal, crash)}
    driven = iter([row for rows in ends.values() for row in rows])

    class Made:
        def __init__(self, environment: Any, task: DriveTask) -> None:
            self.row = next(driven)

    monkeypatch.setattr(
        search, "contested_drives", lambda asked: ((number, f"drive-{number}") for number in ends)
    )
    monkeypatch.setattr(search, "drive", Made)
    unattacked, attacked = (DriveSetting(name, {"perception": "truth"}) for name in "ab")
    found = telling_drive(SCENES, 0, unattacked, attacked)
    passed = PassedOver(12, missed_goal=2, harmless=1)
    assert found == TellingDrive("drive-12", passed)
    assert (passed.contested, next(driven, None)) == (3, None)
    words = passed.in_words()
    for part in ("12 scenes, 3 of them contested", "in 2 the unattacked", "in 1 the light"):
        assert part in words


def test_without_such_a_scene_another_seed_is_asked_for() -> None:
    with pytest.raises(DataError, match="Take another --seed"):
        contested_drive({**SCENES, "count": 2})


@pytest.mark.usefixtures("without_eyes")
def test_all_settings_are_driven_once_and_shown(tmp_path: Path) -> None:
    assert driven_section(tmp_path) is None
    assert driven_rows(tmp_path) == []
    seen: list[tuple[int, int]] = []
    drive_on(tmp_path, 0, on_progress=lambda done, total: seen.append((done, total)))
    assert seen == [(0, 3), (1, 3), (2, 3), (3, 3)]
    rows = driven_rows(tmp_path)
    assert [row["setting"] for row in rows] == ["unattacked", "attacked", "defended"]
    assert [row["outcome"] for row in rows] == ["goal", "collision", "goal"]
    section = driven_section(tmp_path)
    assert section is not None
    words = " ".join(section.sentences)
    assert len(section.sentences) == 3
    assert f"Unattacked: it reaches its goal after {rows[0]['duration']:.1f} s." in words
    assert f"camera: it collides and is to blame after {rows[1]['duration']:.1f} s." in words
    film, strips = section.parts
    assert isinstance(film, Figure)
    assert isinstance(strips, Figure)
    assert f"Scene {TELLING[0].scene}, " in strips.note
    assert "No drive here shows whether the validator also stops the car" in strips.note
    content = film.pictures[0].pictures[0].image.removeprefix("data:image/gif;base64,")
    moving = Image.open(io.BytesIO(base64.b64decode(content)))
    assert sum(1 for _ in ImageSequence.Iterator(moving)) > 20
    assert len(strips.pictures) == 3
    # Given again, nothing is driven anew.
    drive_on(tmp_path, 0, on_progress=lambda done, total: pytest.fail("it drives again"))


@pytest.mark.usefixtures("without_eyes")
def test_the_last_drive_may_be_made_beside_the_others(tmp_path: Path) -> None:
    apart, together = tmp_path / "apart", tmp_path / "together"
    drive_on(apart, 0, but_last=True)
    drive_on(apart, 0, last=last_drive(0))
    drive_on(together, 0)
    assert (apart / ROWS).read_bytes() == (together / ROWS).read_bytes()
    for film in (together / FILMS).iterdir():
        assert (apart / FILMS / film.name).read_bytes() == film.read_bytes()


@pytest.mark.slow
@pytest.mark.usefixtures("without_eyes")
def test_a_full_report_also_drives_the_validator_without_a_laser(tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    drive_on(tmp_path, 0, on_progress=lambda done, total: seen.append((done, total)), control=True)
    assert seen[-1] == (4, 4)
    assert [row["setting"] for row in driven_rows(tmp_path)] == [
        "unattacked", "attacked", "defended", "defended-unattacked",
    ]  # fmt: skip
    section = driven_section(tmp_path)
    assert section is not None
    film, strips = section.parts
    assert isinstance(film, Figure)
    assert isinstance(strips, Figure)
    assert "as a control: it reaches its goal after" in strips.note
    assert film.title == "The same scene, four times"
    assert len(strips.pictures) == 4
    # A demo with three drives is another one.
    assert are_demo_drives(tmp_path, 0, control=True)
    assert not are_demo_drives(tmp_path, 0)


def rows_of(well: bool, at_fault: bool, scene: str = TELLING[0].scene) -> list[Any]:
    """Rows of three drives, of which the defended one stops."""
    first = "goal" if well else "collision"
    ends = {"unattacked": first, "attacked": "collision", "defended": "stopped"}
    return [
        {
            "setting": setting,
            "scenario": scene,
            "seed": 0,
            "outcome": Outcome(outcome),
            "at_fault": at_fault and setting == "attacked",
            "duration": 8.0,
            "path_length": 1.04,
        }
        for setting, outcome in ends.items()
    ]


@pytest.mark.parametrize(
    ("stop", "words"),
    [
        (0.0, "it stands after 8.0 s and 1.0 m; its first emergency stop begins at once."),
        (2.5, "it stands after 8.0 s and 1.0 m; its first emergency stop begins after 2.5 s."),
        (None, "it stands after 8.0 s and 1.0 m, without an emergency stop."),
    ],
)
def test_the_defended_drive_states_how_far_it_came_and_when_it_first_braked_to_a_stop(
    stop: float | None, words: str
) -> None:
    found = [*in_words(rows_of(well=True, at_fault=True), {"defended": stop})]
    assert found[-1] == f"With the laser, and a validator that stops the car at an alarm: {words}"


def test_a_scene_is_only_called_what_its_drives_show(monkeypatch: pytest.MonkeyPatch) -> None:
    passed = PassedOver(7, harmless=1)
    monkeypatch.setitem(TELLING, 0, TellingDrive("drive-000007", passed))

    def first(well: bool, at_fault: bool, scene: str = "drive-000007") -> list[str]:
        return [*beside_in_words(rows_of(well, at_fault, scene), {"defended": 0.0})]

    scene, before, control = first(well=True, at_fault=True)
    assert "No drive here shows" in control
    assert "the first in which" in scene
    assert "the light decides" in scene
    assert before == passed.in_words()
    # The unattacked car collides, or the light does no harm: then the rule is not claimed.
    for well, at_fault in ((False, True), (True, False)):
        scene, control = first(well, at_fault)
        assert "Scene drive-000007, one in which" in scene
        assert "the light decides" not in scene
        assert "No drive here shows" in control
    # Of another scene, the first contested one, nothing is known but that.
    scene, _ = first(well=True, at_fault=True, scene="drive-000002")
    assert "the first in which" in scene
    assert "the light decides" not in scene


@pytest.mark.usefixtures("without_eyes")
def test_a_stopped_demo_goes_on_with_the_scene_that_it_had(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(done: int, total: int) -> None:
        if done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        drive_on(tmp_path, 0, on_progress=stop)
    assert driven_section(tmp_path) is None
    monkeypatch.setattr(demo, "contested_drive", lambda scenarios: pytest.fail("it looks again"))
    drive_on(tmp_path, 0)
    assert len({row["scenario"] for row in driven_rows(tmp_path)}) == 1
    assert len(driven_rows(tmp_path)) == 3


@pytest.mark.slow
@pytest.mark.usefixtures("without_eyes")
def test_processes_that_share_drive_by_drive_make_the_same(tmp_path: Path) -> None:
    drive_on(tmp_path / "one", 0)
    drive_on(tmp_path / "two", 0, jobs=2)
    assert driven_rows(tmp_path / "one") == driven_rows(tmp_path / "two")
