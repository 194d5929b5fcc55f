"""`avsec demo`: table, page and JSON of one run, which goes on and is never written over.

Detections are drawn from a seed (``tests/report/drawn_run.py``), everything behind them is real.
"""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from avsec_gym.cli import run
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.experiments.chapter5 import attacked_episodes, scenes
from avsec_gym.experiments.demo import drive_on
from avsec_gym.runs.run_folder import RunFolder

DONE, BAD_DATA, BAD_USAGE = 0, 1, 2


def ends(*arguments: Any) -> int:
    try:
        return run([*map(str, arguments)])
    except SystemExit as end:
        return int(end.code or 0)


@pytest.fixture(autouse=True)
def made(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[tuple[int, int]]:
    """Which frames are asked for, by number and seed."""
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "report")
    import drawn_run

    asked: list[tuple[int, int]] = []

    def frames(count: int, seed: int, *, contested: bool) -> Path:
        assert contested
        asked.append((count, seed))
        root: Path = drawn_run.write_frames(tmp_path / f"frames-{seed}-{count}", count)
        return root

    monkeypatch.setattr(attacked_episodes, "AttackedEpisodes", drawn_run.DrawnEpisodes)
    monkeypatch.setattr(scenes, "procedural_frames", frames)
    sees = {drive_on.UNATTACKED: "truth", drive_on.ATTACKED: "blind", drive_on.DEFENDED: "truth"}
    unrendered = tuple(DriveSetting(name, {"perception": what}) for name, what in sees.items())
    monkeypatch.setattr(drive_on, "SETTINGS", unrendered)
    scenes._scenes.cache_clear()
    monkeypatch.chdir(tmp_path)
    return asked


@pytest.mark.slow
def test_from_nothing_to_the_page_and_once_more(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, made: list[tuple[int, int]]
) -> None:
    usual = ("demo", "--scenarios", 4, "--workers", 0)
    assert ends(*usual) == DONE
    told = capsys.readouterr()
    for words in (
        "with something in the way", "found before", "safe after", "DSGN", "Stereo R-CNN",
        "thesis PGD α 1, n 4", "trained patch, random place",
    ):  # fmt: skip
        assert words in told.out
    # What was seen stands in sentences first; precision stands on the page.
    assert "Unattacked: it reaches its goal" in told.err
    assert "A grey patch is the control" in told.err
    assert "AP" not in told.out
    assert [line for line in told.err.splitlines() if "report.html" in line] == [
        "runs/demo/report.html: what it is about, in a picture; then come the attacks",
        "runs/demo/report.html: the first scene in a picture; others follow",
        "runs/demo/report.html: the episodes in pictures",
    ]
    out = tmp_path / "runs/demo"
    page = (out / "report.html").read_text()
    for words in ("PGD", "AP at 0.7", "4 scenes show what attacks do", "trained patch, random"):
        assert words in page
    for words in ("random patch", "in italics"):
        assert words not in page
    finished = [cell.finished for cell in RunFolder.open(out).cells()]

    # Given again, it does nothing anew but the page, and `avsec run` knows the run as its own.
    assert ends(*usual, "--json") == DONE
    said = json.loads(capsys.readouterr().out)
    assert ends("run", "demo", "--limit", 4, "--workers", 0) == DONE
    assert " 0 done" in capsys.readouterr().err
    assert [cell.finished for cell in RunFolder.open(out).cells()] == finished

    assert said["out"] == "runs/demo"
    assert [row["setting"] for row in said["drives"]] == ["unattacked", "attacked", "defended"]
    assert {row["detector"] for row in said["rates"]} == {None, "dsgn", "stereo_rcnn"}
    episodes = RunFolder.open(out).records(setting="dsgn thesis_pgd-1", strength=4)
    (row,) = [
        rates for rates in said["rates"] if (rates["detector"], rates["strength"]) == ("dsgn", 4)
    ]
    assert row["safe_driving_rate"] == pytest.approx(sum(each.safe for each in episodes) / 12)
    page = (out / "report.html").read_text()
    for row in said["story"]:
        assert f"{row['found']} of {row['cars']}" in page
        assert f"{row['safe']} of {row['drives']}" in page
    assert "This run cannot tell" not in page

    # Another demo is not written over it, nor are frames made for it.
    made.clear()
    assert ends(*usual, "--seed", 1) == BAD_DATA
    assert "has seed 0, asked is 1" in capsys.readouterr().err
    assert made == []


def test_what_is_not_a_demo_is_left_alone(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, made: list[tuple[int, int]]
) -> None:
    mine = tmp_path / "holiday" / "beach.txt"
    mine.parent.mkdir()
    mine.write_text("sun")
    for out in (mine, mine.parent):
        assert ends("demo", "--scenarios", 1, "--workers", 0, "--out", out) == BAD_DATA
        assert str(out) in capsys.readouterr().err
    assert [path.name for path in mine.parent.iterdir() if path.name[0] != "."] == ["beach.txt"]
    assert mine.read_text() == "sun"
    for wrong in (("--scenarios", 0), ("--seed", -1), ("--workers", -1), ("--scenes", 6)):
        assert ends("demo", *wrong, "--out", tmp_path / "new") == BAD_USAGE
    assert made == []


def test_the_first_page_shows_a_scene_in_which_it_matters_what_a_car_sees(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(count: int, seed: int, *, contested: bool) -> Path:
        raise KeyboardInterrupt

    monkeypatch.setattr(scenes, "procedural_frames", stopped)
    page = tmp_path / "runs/demo/report.html"
    for _ in range(2):  # Stopped while scenes are rendered, it begins again.
        ends("demo", "--workers", 0)
        assert f"{page.relative_to(tmp_path)}: what it is about" in capsys.readouterr().err
        text = page.read_text()
        for words in ("a car that sees nothing", "a car that sees all", "Turn this scene"):
            assert words in text
        outcomes = re.findall(r'class="outcome (\w+)"', text)
        assert outcomes[0] != "safe"
        assert outcomes[1] == "safe"
    # Drives that it had begun do not stop it, other drives do.
    drive_on.drive_on(page.parent / "drives", 0)
    ends("demo", "--workers", 0)
    assert "what it is about" in capsys.readouterr().err
    assert ends("demo", "--workers", 0, "--seed", 1) == BAD_DATA
    assert "what it is about" not in capsys.readouterr().err
    shutil.rmtree(page.parent / "drives")
    # A page of the user's own is not written over.
    page.write_text("<h1>Mine</h1>")
    assert ends("demo", "--workers", 0) == BAD_DATA
    assert page.read_text() == "<h1>Mine</h1>"
