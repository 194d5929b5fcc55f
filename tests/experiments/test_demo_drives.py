"""The scene of the demo in which the car drives on: found by rule, driven under each setting."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import pytest
from PIL import Image, ImageSequence

from avsec_gym.drawing.page_figure import Figure
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.errors import DataError
from avsec_gym.experiments.demo import drive_on as demo
from avsec_gym.experiments.demo.drive_on import (
    contested_drive,
    drive_on,
    driven_rows,
    driven_section,
    in_words,
    telling_drive,
)

SCENES = {"source": "drives", "seed": 0, "count": 20}


@pytest.fixture
def without_eyes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cars that see all, or nothing, so that nothing is rendered."""
    sees = {demo.UNATTACKED: "truth", demo.ATTACKED: "blind", demo.DEFENDED: "truth"}
    settings = tuple(DriveSetting(name, {"perception": what}) for name, what in sees.items())
    monkeypatch.setattr(demo, "SETTINGS", settings)


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
def test_the_light_decides_the_scene_that_is_shown() -> None:
    assert telling_drive({"source": "drives", "seed": 0, "count": 300}, 0) == demo.TELLING[0]


@pytest.mark.usefixtures("without_eyes")
def test_a_scene_is_telling_if_the_unattacked_car_is_safe_in_it_and_the_attacked_one_not() -> None:
    assert telling_drive(SCENES, 0) == contested_drive(SCENES)
    demo.SETTINGS[1].arguments["perception"] = "truth"
    with pytest.raises(DataError, match="the light decides none"):
        telling_drive(SCENES, 0)


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
    words = in_words(rows)
    assert words.startswith("Scene drive-000235, the first in which")
    assert "the light decides" in words
    assert f"Unattacked: it reaches its goal after {rows[0]['duration']:.1f} s." in words
    assert f"camera: collision, at fault after {rows[1]['duration']:.1f} s." in words
    section = driven_section(tmp_path)
    assert section is not None
    film, strips = section.parts
    assert isinstance(film, Figure)
    assert isinstance(strips, Figure)
    content = film.pictures[0].pictures[0].image.removeprefix("data:image/gif;base64,")
    moving = Image.open(io.BytesIO(base64.b64decode(content)))
    assert sum(1 for _ in ImageSequence.Iterator(moving)) > 20
    assert len(strips.pictures) == 3
    # Given again, nothing is driven anew.
    drive_on(tmp_path, 0, on_progress=lambda done, total: pytest.fail("it drives again"))


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
