"""Drives that a process makes beside other work: the same ones, or none, and never in the way."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from avsec_gym.drives.drive_folder import RECORD
from avsec_gym.errors import DataError
from avsec_gym.experiments.demo.drive_ahead import drives_ahead
from avsec_gym.experiments.demo.drive_on import are_demo_drives, drive_on
from avsec_gym.experiments.demo.drive_section import driven_rows


def test_one_process_alone_begins_none(tmp_path: Path) -> None:
    with drives_ahead(tmp_path / "drives", 1, 0, processes=1) as ahead:
        ahead.wait_for_frames(lambda done, total: pytest.fail("a frame is rendered"))
        assert ahead.drive_beside(lambda done, total: pytest.fail("a drive is made")) is None
        ahead.wait_for_drives(lambda done, total: pytest.fail("a drive is made"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_what_goes_wrong_is_left_to_who_drives_on(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / RECORD).write_text('{"format": 2, "settings": {"mine": {}}}')
    (tmp_path / "drives.jsonl").write_text("{}\n")
    with drives_ahead(tmp_path, 1, 0, processes=2) as ahead:
        ahead.wait_for_frames(lambda done, total: None)
        ahead.wait_for_drives(lambda done, total: None)
    assert "Traceback" not in capfd.readouterr().err
    assert not are_demo_drives(tmp_path, 0)
    with pytest.raises(DataError, match=r"drives here are others|drives\.jsonl"):
        drive_on(tmp_path, 0)
    assert (tmp_path / "drives.jsonl").read_text() == "{}\n"


def test_who_does_not_wait_ends_it(tmp_path: Path) -> None:
    begun = time.monotonic()
    with drives_ahead(tmp_path / "drives", 1, 0, processes=2):
        while not (tmp_path / "drives" / RECORD).exists():
            assert time.monotonic() - begun < 120.0
            time.sleep(0.05)
    assert driven_rows(tmp_path / "drives") == []
    assert are_demo_drives(tmp_path / "drives", 0)
    assert not are_demo_drives(tmp_path / "drives", 1)
    # The folder is held no more: what stops another demo is what was begun there.
    with pytest.raises(DataError, match="are others"):
        drive_on(tmp_path / "drives", 1)


@pytest.mark.slow
def test_they_are_the_drives_that_are_made_afterwards(tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    frames: list[tuple[int, int]] = []
    with drives_ahead(tmp_path / "ahead", 1, 0, processes=2) as ahead:
        last = ahead.drive_beside(lambda done, total: seen.append((done, total)))
        ahead.wait_for_frames(lambda done, total: frames.append((done, total)))
        ahead.wait_for_drives(lambda done, total: seen.append((done, total)))
    assert frames[-1:] in ([], [(1, 1)])  # None where the cache has them already.
    assert seen[0] == (0, 3)
    assert sorted(seen) == seen
    # The last one was made here, and is filed by who comes to it.
    assert last is not None
    assert last.row["id"] not in {row["id"] for row in driven_rows(tmp_path / "ahead")}
    filed: list[tuple[int, int]] = []
    drive_on(
        tmp_path / "ahead", 0, on_progress=lambda *done: filed.append(done), last=last
    )  # fmt: skip
    assert filed == [(2, 2), (3, 3)]
    drive_on(tmp_path / "afterwards", 0)
    assert driven_rows(tmp_path / "ahead") == driven_rows(tmp_path / "afterwards")
    assert [row["outcome"] for row in driven_rows(tmp_path / "ahead")] == [
        "goal", "collision", "stopped",
    ]  # fmt: skip
