"""Data sets are resumed, continued, refused and listed; here without any rendering."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.folder_lock import folder_lock
from avsec_gym.world.export import changed_files, default_suites, make_data_set, read_manifest

from .conftest import Texts, contents


def test_makes_and_lists_every_file(tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    root = tmp_path / "new"
    report = make_data_set(Texts(), root, workers=1, on_progress=lambda *n: seen.append(n))
    assert (report.made, report.kept, report.left_out) == (3, 0, 0)
    assert seen == [(1, 3), (2, 3), (3, 3)]
    manifest = read_manifest(tmp_path / "new")
    assert manifest is not None
    assert manifest["complete"]
    assert manifest["frames"] == 3
    assert manifest["settings"] == {"suite": "texts", "word": "a"}
    there = set(contents(tmp_path / "new")) - {"manifest.json"}
    assert set(manifest["files"]) == there
    assert changed_files(tmp_path / "new", full=True) == []


@pytest.mark.parametrize("error", [KeyboardInterrupt(), DataError("The disk is full.")])
def test_goes_on_where_it_stopped(tmp_path: Path, error: BaseException) -> None:
    with pytest.raises(type(error)):
        make_data_set(Texts(fails_at=1, error=error), tmp_path / "cut", workers=1)
    manifest = read_manifest(tmp_path / "cut")
    assert manifest is not None
    assert not manifest["complete"]
    (tmp_path / "cut" / "first" / ".2.txt.77.ab.tmp").write_text("half")
    again = Texts()
    report = make_data_set(again, tmp_path / "cut", workers=1)
    assert again.made == [1, 2]
    assert (report.made, report.kept) == (2, 1)
    make_data_set(Texts(), tmp_path / "whole", workers=1)
    assert contents(tmp_path / "cut") == contents(tmp_path / "whole")


@pytest.mark.parametrize("workers", [1, 2])
def test_a_set_that_was_cut_off_is_completed_with_the_frames_it_has(
    tmp_path: Path, workers: int
) -> None:
    """No frame is left to be made, and there is no work for any process."""
    with pytest.raises(KeyboardInterrupt):
        make_data_set(Texts(4, fails_at=2, error=KeyboardInterrupt()), tmp_path, workers=1)
    for frames in (2, 1):
        report = make_data_set(Texts(frames), tmp_path, workers=workers)
        assert (report.made, report.kept) == (0, frames)
        manifest = read_manifest(tmp_path)
        assert manifest is not None
        assert (manifest["complete"], manifest["frames"]) == (True, 2)


def test_more_frames_continue_and_fewer_keep(tmp_path: Path) -> None:
    make_data_set(Texts(2), tmp_path, workers=1)
    more = Texts(4)
    make_data_set(more, tmp_path, workers=1)
    assert more.made == [2, 3]
    fewer = Texts(1)
    assert make_data_set(fewer, tmp_path, workers=1).kept == 1
    manifest = read_manifest(tmp_path)
    assert manifest is not None
    assert manifest["frames"] == 4
    assert (tmp_path / "list.txt").read_text().count("\n") == 3


def test_other_settings_and_other_versions_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_data_set(Texts(), tmp_path, workers=1)
    before = contents(tmp_path)
    with pytest.raises(DataError, match=r'has word "a", asked is "b".*another folder'):
        make_data_set(Texts(word="b"), tmp_path, workers=1)
    monkeypatch.setattr("avsec_gym.world.export.manifest.world_fingerprint", lambda: "0123")
    with pytest.raises(DataError, match="another version"):
        make_data_set(Texts(5), tmp_path, workers=1)
    assert contents(tmp_path) == before


def test_folders_of_others_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "holiday.png").write_text("sea")
    with pytest.raises(DataError, match="not empty"):
        make_data_set(Texts(), tmp_path, workers=1)
    assert contents(tmp_path) == {"holiday.png": b"sea"}
    with pytest.raises(DataError, match="This is a file"):
        make_data_set(Texts(), tmp_path / "holiday.png", workers=1)
    (tmp_path / "manifest.json").write_text('{"name": "web app"}')
    with pytest.raises(DataError, match="no manifest of a data set"):
        make_data_set(Texts(), tmp_path, workers=1)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write")
def test_folders_that_cannot_be_written(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(DataError, match="cannot be made"):
        make_data_set(Texts(), tmp_path / "new", workers=1)


def test_changes_are_detected(tmp_path: Path) -> None:
    make_data_set(Texts(word="abc"), tmp_path, workers=1)
    (tmp_path / "first" / "0.txt").write_text("abd")
    assert changed_files(tmp_path) == []
    assert changed_files(tmp_path, full=True) == ["first/0.txt"]
    (tmp_path / "first" / "0.txt").write_text("longer")
    assert changed_files(tmp_path) == ["first/0.txt"]
    with pytest.raises(DataError, match="another size"):
        make_data_set(Texts(word="abc"), tmp_path, workers=1)
    (tmp_path / "last" / "0.txt").unlink()
    make_data_set(Texts(word="abc"), tmp_path, workers=1)
    assert changed_files(tmp_path, full=True) == []
    with pytest.raises(DataError, match="no manifest"):
        changed_files(tmp_path / "first")


def test_broken_sources_are_left_out(tmp_path: Path) -> None:
    report = make_data_set(Texts(fails_at=1), tmp_path / "part", workers=1)
    assert (report.made, report.left_out, report.remarks) == (2, 1, ("1 is left out",))
    with pytest.raises(DataError, match="0 is left out"):
        make_data_set(Texts(1, fails_at=0), tmp_path / "none", workers=1)


def test_numbers_are_checked(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="worker"):
        make_data_set(Texts(), tmp_path / "a", workers=0)
    with pytest.raises(ConfigurationError, match="1 frame or more"):
        make_data_set(Texts(0), tmp_path / "a", workers=1)
    assert not (tmp_path / "a").exists()


def test_one_at_a_time(tmp_path: Path) -> None:
    with folder_lock(tmp_path), pytest.raises(DataError, match="Another process"):
        make_data_set(Texts(), tmp_path, workers=1)
    make_data_set(Texts(), tmp_path, workers=1)


def test_the_cache_is_filled_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(default_suites, "cache_folder", lambda: tmp_path)
    recipe, places = Texts(20), []
    threads = [
        threading.Thread(target=lambda: places.append(default_suites.cached("t", recipe, 1)))
        for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(recipe.made) == list(range(20))
    assert len(places) == 3
    assert len(set(places)) == 1
    (places[0] / "last" / "7.txt").write_text("?")
    assert default_suites.cached("t", recipe, 1) == places[0]
    assert changed_files(places[0], full=True) == []


def test_unknown_default_suites() -> None:
    with pytest.raises(ConfigurationError, match="there are street"):
        default_suites.default_suite("moon")
    with pytest.raises(ConfigurationError, match="vehicle=0"):
        default_suites.world_frames("connected")
    with pytest.raises(ConfigurationError, match="vehicle=0"):
        default_suites.world_frames("raw")
