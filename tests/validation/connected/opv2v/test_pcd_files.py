"""PCD files of both kinds hold the points that were written; others are refused."""

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.validation.connected.opv2v.pcd_files import read_pcd
from tests.validation.connected.opv2v.opv2v_sample import pcd_header, write_ascii_pcd

_POINTS = np.random.default_rng(0).uniform(-50, 50, (20, 3)).astype(np.float32)


@pytest.mark.parametrize("red", [0, 1, 127, 255])
def test_ascii_points_with_the_red_of_a_colour(tmp_path: Path, red: int) -> None:
    write_ascii_pcd(tmp_path / "a.pcd", _POINTS, red)
    points = read_pcd(tmp_path / "a.pcd")
    assert points.dtype == np.float32
    assert points[:, :3] == pytest.approx(_POINTS, abs=1e-6)
    assert points[:, 3] == pytest.approx(red / 255)


def test_binary_points_between_padding_and_doubles(tmp_path: Path) -> None:
    table = np.zeros(20, "<f8,<f8,<f8,u1,<f4,3u1")
    for name, values in zip(("f0", "f1", "f2"), _POINTS.T, strict=True):
        table[name] = values
    table["f4"] = 0.25
    header = (
        "VERSION 0.7\nFIELDS x y z _ intensity _\nSIZE 8 8 8 1 4 1\nTYPE F F F U F U\n"
        "COUNT 1 1 1 1 1 3\nWIDTH 5\nHEIGHT 4\nVIEWPOINT 0 0 0 1 0 0 0\nDATA binary\n"
    )
    (tmp_path / "a.pcd").write_bytes(header.encode() + table.tobytes())
    assert read_pcd(tmp_path / "a.pcd") == pytest.approx(
        np.column_stack([_POINTS, np.full(20, 0.25)])
    )


@pytest.mark.parametrize("type", ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8"])
def test_whole_numbers_of_every_size(tmp_path: Path, type: str) -> None:
    """Besides coordinates, a file may have counts of any width; they are passed over."""
    table = np.zeros(20, f"<f4,<f4,<f4,<{type},<f4")
    for name, values in zip(("f0", "f1", "f2"), _POINTS.T, strict=True):
        table[name] = values
    table["f3"], table["f4"] = 7, 0.25
    header = (
        "VERSION 0.7\nFIELDS x y z ring intensity\n"
        f"SIZE 4 4 4 {type[1]} 4\nTYPE F F F {type[0].upper()} F\nCOUNT 1 1 1 1 1\n"
        "WIDTH 20\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nDATA binary\n"
    )
    (tmp_path / "a.pcd").write_bytes(header.encode() + table.tobytes())
    assert read_pcd(tmp_path / "a.pcd") == pytest.approx(
        np.column_stack([_POINTS, np.full(20, 0.25)])
    )


def test_rays_without_a_return_are_left_out(tmp_path: Path) -> None:
    points = np.column_stack([_POINTS, np.zeros(20)]).astype("<f4")
    points[3, :3] = np.nan
    content = pcd_header(20, "binary").encode() + points.tobytes()
    (tmp_path / "a.pcd").write_bytes(content)
    assert len(read_pcd(tmp_path / "a.pcd")) == 19


def _with(old: str, new: str, body: bytes = bytes(32)) -> bytes:
    header = pcd_header(2, "binary")
    assert old in header
    return header.replace(old, new).encode() + body


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (_with("DATA binary", "DATA binary_compressed"), "compressed=False"),
        (_with("DATA binary", "DATA other"), "neither ascii nor binary"),
        (_with("DATA", "DATUM"), "does not begin"),
        (_with("POINTS 2", "POINTS 1000000000"), "promises 1000000000"),
        (_with("WIDTH 2", "WIDTH 99999999999"), "promises"),
        (_with("WIDTH 2", "WIDTH -2"), "WIDTH"),
        (_with("COUNT 1 1 1 1", "COUNT 1 1 1 99999999"), "more than 64"),
        (_with("SIZE 4 4 4 4", "SIZE 4 4 4 3"), "3 bytes"),
        (_with("SIZE 4 4 4 4", "SIZE 4 4 4"), "SIZE"),
        (_with("TYPE F F F F", "TYPE F F F X"), "'X'"),
        (_with("FIELDS x y z", "FIELDS x y w"), "no x, y and z"),
        (_with("VERSION 0.7", "VERSION 0.7\nVERSION 0.7"), "twice"),
        (_with("VERSION 0.7", "VERSION 0.7", bytes(31)), "32 bytes"),
        (_with("VERSION 0.7", "VERSION 0.7", np.full(8, 1e9, "<f4").tobytes()), "beyond"),
        (_with("rgb", "intensity", np.full(8, 3, "<f4").tobytes()), "Divide"),
        (pcd_header(2, "ascii").encode() + b"1 2 3 4 5 6 7", "7 follow"),
        (pcd_header(2, "ascii").encode() + b"1 2 3 4 5 6 7 x", "no number"),
        (_with("TYPE F F F F", "TYPE F F F U").replace(b"binary", b"ascii")[:-32]
         + b"1 2 3 4 5 6 7 -1", "no place"),
        (b"", "does not begin"),
        (b"\xff" * 100_000, "does not begin"),
    ],
)  # fmt: skip
def test_what_is_no_sound_file_is_refused(tmp_path: Path, content: bytes, problem: str) -> None:
    (tmp_path / "a.pcd").write_bytes(content)
    with pytest.raises(DataError, match=problem) as caught:
        read_pcd(tmp_path / "a.pcd")
    assert "a.pcd" in str(caught.value)
