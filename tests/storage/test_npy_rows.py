"""Arrays that are written piece by piece are NumPy's, and a full disk is an error with a name."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.storage.npy_rows import NewFile, NpyRows, npy_header
from tests.full_disk import largest_file


@pytest.mark.parametrize("shape", [(3,), (4, 2), (2, 5, 7, 3), (0, 4)])
@pytest.mark.parametrize("kind", [np.uint8, "<i2", np.float64])
def test_numpy_reads_what_was_written_and_zeros_elsewhere(
    tmp_path: Path, shape: tuple[int, ...], kind: str
) -> None:
    expected = np.zeros(shape, kind)
    with NpyRows(tmp_path / "rows.npy", kind, shape) as rows:
        for index in reversed(range(1, shape[0])):
            expected[index] = np.random.default_rng(index).integers(0, 100, shape[1:])
            rows[index] = expected[index]
    found = np.load(tmp_path / "rows.npy", allow_pickle=False)
    assert found.dtype == expected.dtype
    np.testing.assert_array_equal(found, expected)
    # Byte for byte what NumPy writes.
    np.save(tmp_path / "expected.npy", expected)
    assert (tmp_path / "rows.npy").read_bytes() == (tmp_path / "expected.npy").read_bytes()


def test_room_is_taken_before_anything_is_written(tmp_path: Path) -> None:
    with NpyRows(tmp_path / "rows.npy", np.uint8, (4, 2**18)):
        assert (tmp_path / "rows.npy").stat().st_blocks * 512 >= 2**20


def test_where_no_room_can_be_reserved_zeros_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: int) -> None:
        raise OSError(errno.EOPNOTSUPP, os.strerror(errno.EOPNOTSUPP))

    monkeypatch.setattr(os, "posix_fallocate", refuse)
    with NpyRows(tmp_path / "rows.npy", np.uint8, (5, 2**18)) as rows:
        assert (tmp_path / "rows.npy").stat().st_blocks * 512 >= 5 * 2**18
        rows[1] = np.ones(2**18, np.uint8)
    np.testing.assert_array_equal(np.load(tmp_path / "rows.npy").any(1), [0, 1, 0, 0, 0])


def test_a_disk_without_room_is_an_error_that_names_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(DataError, match=r"No space left on device.*free space") as caught:
        NpyRows(tmp_path / "rows.npy", np.uint8, (4, 2**18))
    assert caught.value.path == str(tmp_path / "rows.npy")


@pytest.mark.parametrize("reserve", [True, False])
def test_a_file_that_cannot_grow_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reserve: bool
) -> None:
    if not reserve:
        monkeypatch.delattr(os, "posix_fallocate")
    with (
        largest_file(2**16),
        pytest.raises(DataError, match="cannot be written") as caught,
        NewFile(tmp_path / "new") as file,
    ):
        file.reserve(2**17)
    assert caught.value.path == str(tmp_path / "new")


def test_of_two_files_that_which_has_no_room_is_named(tmp_path: Path) -> None:
    with NewFile(tmp_path / "one") as one, NewFile(tmp_path / "two") as two:
        one.write(bytes(60_000))
        two.write(npy_header(np.uint8, (60_000,)))
        with largest_file(2**15), pytest.raises(DataError) as caught:
            one.copy_to(two)
    assert caught.value.path == str(tmp_path / "two")


def test_no_file_is_written_over(tmp_path: Path) -> None:
    (tmp_path / "rows.npy").write_text("mine")
    with pytest.raises(DataError, match="exists"):
        NpyRows(tmp_path / "rows.npy", np.uint8, (4,))
    assert (tmp_path / "rows.npy").read_text() == "mine"
