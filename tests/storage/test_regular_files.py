from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from avsec_gym.errors import DataError
from avsec_gym.storage.regular_files import (
    check_regular,
    is_file,
    is_folder,
    is_there,
    open_regular,
    read_bytes,
    read_text,
)


def test_regular_files_are_read(tmp_path: Path) -> None:
    path = tmp_path / "file"
    for content in (b"", b"x", bytes(range(128)) * 1000):
        path.write_bytes(content)
        assert read_bytes(path, most=len(content)) == content
        assert read_text(path) == content.decode()
        assert check_regular(path, most=len(content)) == len(content)
        with open_regular(path, most=len(content)) as file:
            assert file.read() == content
    (tmp_path / "link").symlink_to(path)
    assert read_bytes(tmp_path / "link", most=10**6) == content


def test_what_is_no_file_is_not_read(tmp_path: Path) -> None:
    """None of these may block, or be read to an end that never comes."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for name in ("zero", "tty", "full"):
        (tmp_path / name).symlink_to(f"/dev/{name}")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for path in (tmp_path, *sorted(tmp_path.iterdir())):
        for read in (read_bytes, check_regular):
            with pytest.raises(DataError) as caught:
                read(path, most=100)
            assert caught.value.path == str(path)
            assert caught.value.remedy
        assert not is_file(path)
    assert is_folder(tmp_path)
    assert is_there(pipe)


@pytest.mark.parametrize("name", ["absent", "n" * 300, "a\0b", "/".join(["deep"] * 3000), "\ud800"])
def test_names_that_no_file_has(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    for read in (read_bytes, check_regular):
        with pytest.raises(DataError, match=r"no such file|No file can") as caught:
            read(path, most=100)
        assert len(str(caught.value)) < 2000
        assert str(caught.value).isprintable()
    assert not any(look(path) for look in (is_file, is_folder, is_there))


def test_no_more_is_read_than_was_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(bytes(101))
    for read in (read_bytes, check_regular, read_text):
        with pytest.raises(DataError, match="101 bytes, such a file at most 100"):
            read(path, most=100)  # type: ignore[operator]
    if Path("/proc/self/maps").exists():  # A regular file that reports no bytes.
        with pytest.raises(DataError, match="such a file at most 100"):
            read_bytes("/proc/self/maps", most=100)


def test_what_may_not_be_read_is_named(tmp_path: Path) -> None:
    if os.geteuid() == 0:
        pytest.skip("nothing is forbidden to root")
    path = tmp_path / "file"
    path.touch()
    path.chmod(stat.S_IWUSR)
    with pytest.raises(DataError, match="Permission denied"):
        read_bytes(path, most=100)


def test_text_is_utf_8(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"one\ntwo \xff")
    with pytest.raises(DataError, match="0xff is not UTF-8") as caught:
        read_text(path)
    assert caught.value.line == 2
