from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import box_corners, transform_points
from avsec_gym.kitti.raw_calibration import read_raw_calibration
from avsec_gym.kitti.tracklets import (
    LABELLED,
    Tracklet,
    read_tracklets,
    tracklet_boxes,
    write_tracklets,
)

REAL = "kitti/raw/2011_09_26/2011_09_26_drive_0001_sync/tracklet_labels.xml"


def tracklet(first_frame: int = 3, count: int = 2, category: str = "Car") -> Tracklet:
    translation = np.array([20.0, 4.0, -1.7]) + np.arange(count)[:, None]
    return Tracklet(
        category=category,
        dimensions=np.array([1.5, 1.6, 4.1]),
        first_frame=first_frame,
        translation=translation,
        rotation=np.stack([np.zeros(count), np.zeros(count), np.arange(count) + 0.5], axis=1),
        state=np.full(count, LABELLED),
        occlusion=np.full(count, 1),
        truncation=np.full(count, 0),
    )


def assert_equal(one: Tracklet, two: Tracklet) -> None:
    for name in vars(one):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))


number = st.floats(-1e6, 1e6)
pose = st.tuples(number, number, number, st.integers(0, 2), st.integers(-1, 2), st.floats(-4, 4))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(
    st.lists(
        st.tuples(st.integers(0, 999), st.lists(pose, min_size=1, max_size=3), st.floats(0.01, 10)),
        max_size=3,
    )
)
def test_tracklets_come_back(
    tmp_path: Path, every: list[tuple[int, list[tuple[float, ...]], float]]
) -> None:
    given = []
    for first, rows, size in every:
        table = np.array(rows)
        zero = np.zeros(len(rows))
        given.append(
            Tracklet(
                category="Person_sitting",
                dimensions=np.array([size, 1.0, 2.0]),
                first_frame=first,
                translation=table[:, :3],
                rotation=np.stack([zero, zero, table[:, 5]], axis=1),
                state=table[:, 3].astype(int),
                occlusion=table[:, 4].astype(int),
                truncation=np.full(len(rows), 99),
            )
        )
    path = tmp_path / "tracklet_labels.xml"
    write_tracklets(path, given, overwrite=True)
    for one, two in zip(given, read_tracklets(path), strict=True):
        assert_equal(one, two)


def test_the_real_file_comes_out_as_it_was(shared: Path, tmp_path: Path) -> None:
    tracklets = read_tracklets(shared / REAL)
    assert len(tracklets) == 15
    assert sum(len(t.frames) for t in tracklets) == 572
    write_tracklets(tmp_path / "tracklet_labels.xml", tracklets)
    written = (tmp_path / "tracklet_labels.xml").read_bytes()
    assert written == (shared / REAL).read_bytes()
    with pytest.raises(DataError, match="exists"):
        write_tracklets(tmp_path / "tracklet_labels.xml", tracklets)


def test_boxes_of_a_frame(rig: Calibration) -> None:
    tracklets = [tracklet(3), tracklet(4, 5, "Van"), tracklet(9)]
    assert len(tracklet_boxes(tracklets, 2, rig)) == 0
    assert tracklet_boxes(tracklets, 4, rig).category.tolist() == ["Car", "Van"]
    assert tracklet_boxes(tracklets, 4, rig).occlusion.tolist() == [1, 1]  # type: ignore[union-attr]


def test_a_box_has_the_corners_that_the_tracklet_has(rig: Calibration, shared: Path) -> None:
    """Corners made in the velodyne frame, as the devkit draws them, and then transformed."""
    real = read_raw_calibration((shared / REAL).parent.parent)
    for calibration in (rig, real):
        one = tracklet()
        boxes = tracklet_boxes([one], 4, calibration)
        height, width, length = one.dimensions
        signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) / 2
        foot = np.column_stack([signs * [length, width], np.zeros(4)])
        cos, sin = np.cos(1.5), np.sin(1.5)
        foot = foot @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) + one.translation[1]
        corners = np.vstack([foot, foot + np.array([0, 0, height])])
        expected = transform_points(calibration.velodyne_to_camera, corners)
        found = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)[0]
        # A camera frame's box stands upright in it: the rig's tilt of some degrees remains.
        np.testing.assert_allclose(found, expected, atol=0.2 if calibration is rig else 0.05)
        assert np.linalg.norm(found - expected, axis=1).mean() < 0.15


def _first(text: str, replacement: str) -> Callable[[str], str]:
    return lambda whole: whole.replace(text, replacement, 1)


BOMB = '<!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;">]>'
BROKEN = {
    "empty": (lambda _: "", "no well-formed XML"),
    "cut off": (lambda text: text[: len(text) // 2], "no well-formed XML"),
    "another": (lambda _: "<CommonRoad/>", "begins with <boost_serialization>, this one <Common"),
    "entities": (_first("<!DOCTYPE boost_serialization>", BOMB), ":2: .*declares an entity"),
    "deep": (lambda _: "<a>" * 1000, "nested too deeply"),
    "count": (_first("<count>1", "<count>2"), ":5: <tracklets> promises 2 items and has 1"),
    "poses": (_first("<count>2", "<count>3"), ":14: <poses> promises 3 items and has 2"),
    "word": (_first("<tx>20", "<tx>here"), ":17: <tx> holds 'here'"),
    "NaN": (_first("<rz>0.5", "<rz>nan"), ":22: <rz> holds 'nan'"),
    "huge": (_first("<tx>20", "<tx>1e300"), "too large"),
    "missing": (_first("<tz>-1.7</tz>", ""), ":16: <item> lacks a <tz>"),
    "twice": (_first("<ty>4</ty>", "<ty>4</ty><ty>4</ty>"), "second <ty>"),
    "no size": (_first("<h>1.5", "<h>0"), ":7: .*above 0"),
    "between frames": (_first("<first_frame>3", "<first_frame>3.5"), "no whole number"),
    "before": (_first("<first_frame>3", "<first_frame>-3"), "first frame of 0 or more"),
    "no word": (_first("Car", "a car"), "plain word"),
    "no poses": (
        lambda text: (
            text[: text.index("<count>2")] + "<count>0</count></poses></item></tracklets>"
            "</boost_serialization>"
        ),
        "got 0 poses",
    ),
}


@pytest.mark.parametrize(("change", "message"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_file_is_named(tmp_path: Path, change: Callable[[str], str], message: str) -> None:
    path = tmp_path / "tracklet_labels.xml"
    write_tracklets(path, [tracklet()])
    text = change(path.read_text())
    assert text != path.read_text()
    path.write_text(text)
    with pytest.raises(DataError, match=message) as caught:
        read_tracklets(path)
    assert caught.value.path == str(path)
    assert caught.value.line
    assert caught.value.remedy


def test_a_huge_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "tracklet_labels.xml"
    with open(path, "wb") as file:
        file.truncate(2**30)
    with pytest.raises(DataError, match="1073741824 bytes"):
        read_tracklets(path)


def test_older_files_lack_the_notes(tmp_path: Path) -> None:
    path = tmp_path / "tracklet_labels.xml"
    write_tracklets(path, [tracklet()])
    lines = [line for line in path.read_text().splitlines() if "amt_" not in line]
    path.write_text("\n".join(lines))
    assert_equal(read_tracklets(path)[0], tracklet())


def test_tracklets_are_checked() -> None:
    for change in (
        {"dimensions": np.zeros(3)},
        {"dimensions": np.array([1.5, 1.6, 51.0])},
        {"translation": np.full((2, 3), np.nan)},
        {"state": np.zeros(3)},
        {"first_frame": -1},
        {"category": "a car"},
    ):
        with pytest.raises(ConfigurationError):
            Tracklet(**{**vars(tracklet()), **change})
