from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.timestamps import read_timestamps, write_timestamps


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.integers(0, 4 * 10**18) | st.none(), min_size=1, max_size=9))
def test_times_come_back(tmp_path: Path, nanoseconds: list[int | None]) -> None:
    path = tmp_path / "timestamps.txt"
    nanoseconds.append(12)
    times = np.array(nanoseconds, "datetime64[ns]")
    write_timestamps(path, times, overwrite=True)
    np.testing.assert_array_equal(read_timestamps(path), times)


def test_lines_are_as_kitti_has_them(tmp_path: Path) -> None:
    path = tmp_path / "timestamps.txt"
    times = np.array(["2026-01-01T12:00:00", "NaT", "2026-01-01T12:00:00.2"], "datetime64[ns]")
    write_timestamps(path, times)
    first, lost, last = path.read_text().splitlines()
    assert first == "2026-01-01 12:00:00.000000000"
    assert lost == ""
    assert last == "2026-01-01 12:00:00.200000000"
    with pytest.raises(DataError, match="exists"):
        write_timestamps(path, times)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("", None),
        ("\n\n", None),
        ("2011-09-26 13:02:25.9\nnow\n", 2),
        ("2011-09-26 13:02:25.9\n\n2011-13-26 13:02:25\n", 3),
        ("2011-09-26T13:02:25.9\n", 1),
        ("1317042145.9\n", 1),
        ("2011-09-26 13:02:2", 1),
    ],
)
def test_a_broken_line_is_named(tmp_path: Path, text: str, line: int | None) -> None:
    path = tmp_path / "timestamps.txt"
    path.write_text(text)
    with pytest.raises(DataError, match="time") as caught:
        read_timestamps(path)
    assert caught.value.line == line
    assert caught.value.remedy


def test_what_is_no_time_is_refused(tmp_path: Path) -> None:
    for wrong in (
        np.arange(3),
        np.array([], "datetime64[ns]"),
        np.array(["NaT"], "datetime64[ns]"),
        np.zeros((1, 2), "datetime64[ns]"),
    ):
        with pytest.raises(ConfigurationError):
            write_timestamps(tmp_path / "timestamps.txt", wrong)


def test_a_real_file_comes_out_as_it_was(shared: Path, tmp_path: Path) -> None:
    source = shared / "kitti/raw/2011_09_26/2011_09_26_drive_0001_sync/oxts/timestamps.txt"
    times = read_timestamps(source)
    assert len(times) == 108
    seconds = np.diff(times) / np.timedelta64(1, "s")
    assert ((seconds > 0.08) & (seconds < 0.12)).all()
    write_timestamps(tmp_path / "timestamps.txt", times)
    assert (tmp_path / "timestamps.txt").read_bytes() == source.read_bytes()


def test_years_that_nanoseconds_cannot_count_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "timestamps.txt"
    for year in ("0001", "1677", "2263", "9999"):
        path.write_text(f"{year}-09-26 13:02:25.964389445\n")
        with pytest.raises(DataError, match="holds a time"):
            read_timestamps(path)
