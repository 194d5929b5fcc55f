"""Folders are made, or the file that stands in their way is named."""

from __future__ import annotations

from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.folder_lock import locked_folder
from avsec_gym.storage.folders import made_folder, make_folder


def test_folders_are_made_and_may_be_there(tmp_path: Path) -> None:
    for _ in range(2):
        make_folder(tmp_path / "a" / "b")
    assert (tmp_path / "a" / "b").is_dir()


@pytest.mark.parametrize("below", ["", "b", "b/c"])
def test_a_file_in_the_way_is_named(tmp_path: Path, below: str) -> None:
    file = tmp_path / "file"
    file.write_text("mine")
    for make in (make_folder, lambda folder: write_bytes(folder / "new.txt", b"")):
        with pytest.raises(DataError, match="where a folder is needed") as caught:
            make(file / below)
        assert caught.value.path == str(file)
    assert file.read_text() == "mine"


@pytest.mark.parametrize("name", ["a\0b", "x" * 300])
def test_names_that_no_folder_has(tmp_path: Path, name: str) -> None:
    with pytest.raises(DataError, match="cannot be made"):
        make_folder(tmp_path / name)


def test_a_folder_in_a_file_s_place_is_named(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    with pytest.raises(DataError, match="where a file is to be written"):
        write_bytes(tmp_path / "there", b"content", overwrite=True)
    assert not list(tmp_path.glob(".*"))


def test_an_empty_path_is_no_folder() -> None:
    with pytest.raises(DataError, match="path is empty"):
        make_folder("")
    for take in (made_folder, locked_folder):
        with pytest.raises(DataError, match="path is empty"), take(""):
            pass


def stopped(folder: Path, *names: str) -> None:
    """What is stopped by Ctrl-C when it has written files of these names into a folder."""
    with made_folder(folder) as made:
        assert made.is_dir()
        for name in names:
            (made / name).touch()
        raise KeyboardInterrupt


def test_folders_of_which_nothing_came_go_again(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    for place in ("a/b/c", "mine/b", "mine"):
        with pytest.raises(KeyboardInterrupt):
            stopped(tmp_path / place)
    assert [path.name for path in tmp_path.rglob("*")] == ["mine"]


def test_folders_that_hold_something_stay(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        stopped(tmp_path / "a" / "b", "../kept")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["a", "kept"]
    with made_folder(tmp_path / "c"):
        pass
    assert (tmp_path / "c").is_dir()


def test_a_folder_that_cannot_be_made_leaves_none_above_it(tmp_path: Path) -> None:
    with (
        pytest.raises(DataError, match="cannot be made"),
        made_folder(tmp_path / "a" / ("b" * 300)),
    ):
        pass
    assert not list(tmp_path.iterdir())
