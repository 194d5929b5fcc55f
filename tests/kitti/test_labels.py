from __future__ import annotations

import contextlib
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.label_folders import read_label_folder
from avsec_gym.kitti.labels import (
    read_detections,
    read_labels,
    write_detections,
    write_labels,
)

GOOD = "Car 0.00 1 -1.85 733.06 182.54 934.34 317.95 1.45 1.49 3.79 2.73 1.60 9.79 -1.58"
DONT_CARE = "DontCare -1 -1 -10 579.44 175.79 595.04 188.10 -1 -1 -1 -1000 -1000 -1000 -10"


def write(folder: Path, content: str | bytes) -> Path:
    path = folder / "000107.txt"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def test_columns_go_where_kitti_says(tmp_path: Path) -> None:
    boxes = read_labels(write(tmp_path, GOOD + "\n"))
    assert boxes.category.tolist() == ["Car"]
    assert boxes.truncation is not None
    assert boxes.truncation.tolist() == [0.0]
    assert boxes.occlusion is not None
    assert boxes.occlusion.tolist() == [1.0]
    assert boxes.alpha is not None
    assert boxes.alpha.tolist() == [-1.85]
    assert boxes.box2d is not None
    assert boxes.box2d.tolist() == [[733.06, 182.54, 934.34, 317.95]]
    assert boxes.dimensions.tolist() == [[1.45, 1.49, 3.79]]
    assert boxes.location.tolist() == [[2.73, 1.60, 9.79]]
    assert boxes.rotation_y.tolist() == [-1.58]
    assert boxes.score.tolist() == [1.0]
    assert boxes.length.tolist() == [3.79]


def test_dont_care_is_dropped_unless_every_line_is_wanted(tmp_path: Path) -> None:
    path = write(tmp_path, f"{DONT_CARE}\n{GOOD}\n{DONT_CARE}\n")
    assert read_labels(path).category.tolist() == ["Car"]
    kept = read_labels(path, keep_dont_care=True)
    assert kept.category.tolist() == ["DontCare", "Car", "DontCare"]
    assert kept.location[0].tolist() == [-1000.0] * 3


def test_no_lines_are_no_objects(tmp_path: Path) -> None:
    for content in ("", "\n", f"{DONT_CARE}\n"):
        assert len(read_labels(write(tmp_path, content))) == 0
    assert len(read_detections(write(tmp_path, "\n\n"))) == 0


def test_harmless_variations_are_read(tmp_path: Path) -> None:
    plain = read_labels(write(tmp_path, GOOD + "\n"))
    for content in (
        GOOD,
        GOOD + "\r\n",
        GOOD + " \n\n",
        GOOD.replace(" ", "\t"),
        GOOD.replace("1.45", "1.45e0"),
    ):
        boxes = read_labels(write(tmp_path, content))
        assert boxes.dimensions.tolist() == plain.dimensions.tolist()
    for name in ("Traffic_cone", "Straßenbahn", "Van-2_0", "bus_1_2"):
        boxes = read_labels(write(tmp_path, GOOD.replace("Car", name)))
        assert boxes.category.tolist() == [name]


def test_results_as_detectors_write_them(tmp_path: Path) -> None:
    line = GOOD.replace("0.00 1 -1.85", "-1 -1 0")
    boxes = read_detections(write(tmp_path, f"{line} 172.5 \n\n{line} -3e-2\n{DONT_CARE} 1\n\n\n"))
    assert boxes.score.tolist() == [172.5, -0.03]
    assert boxes.occlusion is not None
    assert boxes.occlusion.tolist() == [-1, -1]


BROKEN = {
    "three columns": ("Car 0.00 1", 1, "15 columns, this one has 3"),
    "cut off": (f"{GOOD}\n{GOOD[:40]}", 2, "cut off"),
    "a result": (f"{GOOD} 0.97", 1, "detector's result"),
    "a tracking label": (f"0 -1 {GOOD}", 1, "tracking"),
    "surplus columns": (f"{GOOD} 0.9 7 8", 1, "surplus"),
    "blank line inside": (f"{GOOD}\n\n{GOOD}", 2, "blank line"),
    "not a number": (GOOD.replace("9.79", "9,79"), 1, "Column 14 holds '9,79'"),
    "grouped digits": (GOOD.replace("733.06", "7_33.06"), 1, "not a number"),
    "other digits": (GOOD.replace("9.79", "٩"), 1, "not a number"),
    "hexadecimal": (GOOD.replace("9.79", "0x10"), 1, "not a number"),
    "nan": (f"{GOOD}\n{GOOD.replace('9.79', 'nan')}", 2, "not finite"),
    "infinite": (GOOD.replace("9.79", "-inf"), 1, "not finite"),
    "overflow": (GOOD.replace("9.79", "1e999"), 1, "not finite"),
    "absurd": (GOOD.replace("9.79", "1e7"), 1, "too large"),
    "flat": (GOOD.replace("1.45", "0.00"), 1, "positive sizes"),
    "negative size": (f"{DONT_CARE}\n{GOOD.replace('3.79', '-3.79')}", 2, "positive sizes"),
    "sizes only in 2D": (f"{GOOD.replace('1.45 1.49 3.79', '-1 -1 -1')}", 1, "positive sizes"),
    "size hidden by a DontCare": (
        f"{DONT_CARE.replace('-1 -1 -1 -1000', '1 1 1 -1000')}\n"
        f"{GOOD.replace('1.45 1.49 3.79', '-1 -1 -1')}",
        2,
        "positive sizes",
    ),
    "number as category": (GOOD.replace("Car", "0.0"), 1, "not a word"),
    "control byte": (GOOD + "\n" + GOOD.replace("Car", "C\x07ar"), 2, "unprintable"),
    "NUL bytes": ("\0" * 40, 1, "unprintable"),
    "byte order mark": ("\ufeff" + GOOD, 1, "byte order mark"),
    "odd blank": (GOOD.replace(" ", "\u00a0", 1), 1, "unprintable"),
    "not UTF-8": (f"{GOOD}\n".encode() + b"Caf\xe9", 2, "0xe9"),
    "gzip": (b"\x1f\x8b\x08\x00", 1, "not UTF-8"),
}


@pytest.mark.parametrize(("content", "line", "message"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_label_is_named(
    tmp_path: Path, content: str | bytes, line: int, message: str
) -> None:
    path = write(tmp_path, content)
    with pytest.raises(DataError) as caught:
        read_labels(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert message in str(caught.value)
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("content", "line", "message"),
    [
        (f"{GOOD} 0.9\n{GOOD}\n", 2, "ground truth"),
        (f"{GOOD} 0.9 7\n", 1, "16 columns, this one has 17"),
        (f"\n{GOOD} nan\n", 2, "not finite"),
        (f"\n{GOOD} x\n", 2, "Column 16"),
    ],
)
def test_a_broken_result_is_named(tmp_path: Path, content: str, line: int, message: str) -> None:
    path = write(tmp_path, content)
    with pytest.raises(DataError) as caught:
        read_detections(path)
    assert str(caught.value).startswith(f"{path}:{line}: ")
    assert message in str(caught.value)
    assert caught.value.remedy


def test_what_is_no_text_file_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "large.txt").open("wb") as file:
        file.truncate(2**30)
    for path in (tmp_path / "absent.txt", tmp_path, tmp_path / "large.txt", "nul\0byte"):
        with pytest.raises(DataError) as caught:
            read_labels(path)
        assert caught.value.path == str(path)
        assert caught.value.remedy


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.text()
    | st.lists(
        st.lists(
            st.sampled_from(["Car", "DontCare", "1.5", "-1", "nan", "1e999", "1_0", "٣", "\x1c"]),
            min_size=13,
            max_size=17,
        ).map(" ".join)
    ).map("\n".join)
    | st.binary()
)
@example("\x0b").via("whitespace for split(), not for a text file")
def test_any_content_gives_boxes_or_a_data_error(tmp_path: Path, content: str | bytes) -> None:
    if isinstance(content, str):
        content = content.encode("utf-8", "surrogatepass")
    path = write(tmp_path, content)
    for read in (read_labels, read_detections):
        with contextlib.suppress(DataError):
            boxes = read(path)
            assert np.isfinite(boxes.location).all()
            assert (boxes.dimensions > 0).all()


@st.composite
def random_boxes(draw: st.DrawFn) -> Boxes3D:
    count = draw(st.integers(0, 4))

    def array(*tail: int, least: float, most: float) -> np.ndarray:
        size = count * math.prod(tail)
        number = st.floats(least, most)
        return np.array(draw(st.lists(number, min_size=size, max_size=size))).reshape(count, *tail)

    def of(*values: float) -> np.ndarray:
        return np.array([draw(st.sampled_from(values)) for _ in range(count)], float)

    corners = array(2, 2, least=-1e6, most=1e6)
    return Boxes3D(
        location=array(3, least=-1000, most=1000) * (1.0, 0.1, 1.0),
        dimensions=array(3, least=1e-9, most=10),
        rotation_y=array(least=-math.pi, most=math.pi),
        score=array(least=-1e6, most=1e6),
        category=np.array([draw(st.sampled_from(["Car", "Van", "Cone"])) for _ in range(count)]),
        box2d=np.concatenate([corners.min(axis=1), corners.max(axis=1)], axis=1),
        truncation=of(-1, 0, 0.25, 1),
        occlusion=of(-1, 0, 1, 2, 3),
        alpha=of(-10, -math.pi, 0.1, 3.1),
    )


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(random_boxes())
def test_written_boxes_come_back(tmp_path: Path, boxes: Boxes3D) -> None:
    path = tmp_path / "boxes.txt"
    fields = set(Boxes3D.__dataclass_fields__) - {"score", "moving"}
    for writer, reader in ((write_labels, read_labels), (write_detections, read_detections)):
        writer(path, boxes, overwrite=True)
        again = reader(path)
        for name in fields:
            np.testing.assert_array_equal(getattr(again, name), getattr(boxes, name), err_msg=name)
    np.testing.assert_array_equal(again.score, boxes.score)


def test_unknown_fields_become_placeholders(tmp_path: Path) -> None:
    path = tmp_path / "000000.txt"
    write_detections(
        path,
        Boxes3D([[1, 2, 3.25]], [[1, 2, 4]], [0.1], [0.7], ["Car"]),  # type: ignore[arg-type]
    )
    assert path.read_text() == (
        "Car -1 -1 -10 -1.0 -1.0 -1.0 -1.0 1.0 2.0 4.0 1.0 2.0 3.25 0.1 0.7\n"
    )


def test_nothing_is_overwritten_unasked_and_nothing_bad_is_written(tmp_path: Path) -> None:
    path = write(tmp_path, GOOD + "\n")
    boxes = read_labels(path)
    with pytest.raises(DataError, match="exists"):
        write_labels(path, Boxes3D.empty())
    assert path.read_text() == GOOD + "\n"
    new = tmp_path / "sub" / "000001.txt"
    for bad in ("two words", "line\nbreak", "", "3D"):
        with pytest.raises(ConfigurationError):
            write_labels(new, _with(boxes, category=np.array([bad])))
    with pytest.raises(DataError, match="positive"):
        write_labels(new, _with(boxes, dimensions=np.zeros((1, 3))))
    assert [entry.name for entry in tmp_path.rglob("*")] == ["000107.txt"]


CAR = GOOD.split()
IMPOSSIBLE = {
    "truncated by more than all": (1, "1.01"),
    "truncated by less than nothing": (1, "-0.5"),
    "occluded beyond unknown": (2, "4"),
    "occluded by half": (2, "0.5"),
    "occluded below unknown": (2, "-2"),
    "alpha beyond a turn": (3, "13"),
    "ends left of its beginning": (6, "700"),
    "ends above its beginning": (7, "182.53"),
    "a kilometre high": (8, "1001"),
    "a kilometre to the left": (11, "-1000.5"),
    "a kilometre ahead": (13, "1001"),
    "in the sky": (12, "-100.5"),
    "below the road": (12, "101"),
    "rotated beyond a turn": (14, "-13"),
}


@pytest.mark.parametrize(("column", "value"), IMPOSSIBLE.values(), ids=IMPOSSIBLE.keys())
def test_what_cannot_be_is_refused(tmp_path: Path, column: int, value: str) -> None:
    words = [*CAR[:column], value, *CAR[column + 1 :]]
    for reader, end in ((read_labels, ""), (read_detections, " 0.5")):
        path = write(tmp_path, f"{GOOD}{end}\n{' '.join(words)}{end}\n")
        with pytest.raises(DataError) as caught:
            reader(path)
        assert caught.value.line == 2
        assert "of a Car" in caught.value.problem or "A Car" in caught.value.problem


@pytest.mark.parametrize("column", [3, 14])
def test_a_region_of_no_care_has_no_angle_of_a_thousand_turns(tmp_path: Path, column: int) -> None:
    """Its numbers are placeholders, and are kept on request; but Boxes3D takes no such angle."""
    box = GOOD.split()[4:8]
    words = ["DontCare", "-1", "-1", "-10", *box, *["-1"] * 3, *["-1000"] * 3, "-10"]
    read_labels(write(tmp_path, " ".join(words)), keep_dont_care=True)
    words[column] = "-10000"
    path = write(tmp_path, f"{GOOD}\n{' '.join(words)}\n")
    with pytest.raises(DataError, match=r":2: An angle of a DontCare is -10000"):
        read_labels(path, keep_dont_care=True)


@pytest.mark.parametrize("sizes", ["300 300 900", "10.1 1.6 4", "1.5 10.1 4", "1.5 1.6 50.1"])
def test_labels_have_sizes_of_vehicles(tmp_path: Path, sizes: str) -> None:
    line = " ".join([*CAR[:8], sizes, *CAR[11:]])
    path = write(tmp_path, f"{GOOD}\n{line}\n")
    with pytest.raises(DataError, match=r":2: A Car measures .*; 10 x 10 x 50 m is the most"):
        read_labels(path)
    # A detector may be wrong, but not by any length; the largest of KITTI's trams are read.
    path = write(tmp_path, f"{line} 0.5")
    if sizes.startswith("300"):
        with pytest.raises(DataError, match=r":1: A Car measures .*; 20 x 100 x 100 m is the most"):
            read_detections(path)
    else:
        assert len(read_detections(path)) == 1
    tram = " ".join(["Tram", *CAR[1:8], "4.2 3.02 35.24", *CAR[11:]])
    assert len(read_labels(write(tmp_path, tram))) == 1


def test_every_number_of_a_line_has_bounds(tmp_path: Path) -> None:
    """The quick look at a file and the slow one at a line agree, whatever the number."""
    for column in range(1, 15):
        for value in (
            "-1e5",
            "-1000.1",
            "-999",
            "-100.1",
            "-11",
            "-9",
            "-4",
            "-0.1",
            "4",
            "7",
            "11",
            "60",
            "100.1",
            "999",
            "1000.1",
            "1e7",
        ):
            words = [*CAR[:column], value, *CAR[column + 1 :]]
            path = write(tmp_path, " ".join(words))
            with contextlib.suppress(DataError):  # Anything else is the assertion of the reader.
                read_labels(path)
            if value == "1e7":
                with pytest.raises(DataError):
                    read_labels(path)


@pytest.mark.parametrize("place", ["-999 -999 -999", "-1000 -999 -1000", "999 999 999"])
def test_other_signs_of_no_place_are_no_places(place: str, tmp_path: Path) -> None:
    """A car that drove by such detections would take the road for free."""
    line = " ".join([*CAR[:11], place, CAR[14], "0.9"])
    with pytest.raises(DataError, match="below the camera"):
        read_detections(write(tmp_path, line))


def test_angles_of_detectors_may_have_turns_too_many(tmp_path: Path) -> None:
    line = " ".join([*CAR[:3], "-7.5", *CAR[4:14], "4.4"])
    assert read_detections(write(tmp_path, line + " 173.5")).rotation_y.tolist() == [4.4]
    with pytest.raises(DataError, match="alpha"):
        read_labels(write(tmp_path, line))


def test_a_region_not_to_care_about_has_a_box_and_placeholders(tmp_path: Path) -> None:
    # The tracking benchmark's placeholders stand in other columns than the object benchmark's.
    odd = "DontCare -1 -1 -10 1 2 3 4 -1000 -1000 -1000 -10 -1 -1 -1"
    assert len(read_labels(write(tmp_path, odd), keep_dont_care=True)) == 1
    with pytest.raises(DataError, match="2D box"):
        read_labels(write(tmp_path, odd.replace("1 2 3 4", "3 2 1 4")))


def _with(boxes: Boxes3D, **changes: np.ndarray) -> Boxes3D:
    columns = {name: getattr(boxes, name) for name in boxes.__dataclass_fields__}
    return Boxes3D(**(columns | changes))


def test_kittis_own_labels_come_out_byte_for_byte(shared: Path, tmp_path: Path) -> None:
    folder = shared / "kitti/object/training/label_2"
    labels = read_label_folder(folder, keep_dont_care=True)
    assert len(labels) == 7481
    for id in [*list(labels)[::200], "000107", "000124"]:
        write_labels(tmp_path / f"{id}.txt", labels[id], overwrite=True)
        assert (tmp_path / f"{id}.txt").read_bytes() == (folder / f"{id}.txt").read_bytes()


def test_kittis_labels_agree_with_a_hand_parse(shared: Path) -> None:
    folder = shared / "kitti/object/training/label_2"
    labels = read_label_folder(folder)
    names = np.concatenate([boxes.category for boxes in labels.values()])
    assert len(names) == 40570
    assert (names == "Car").sum() == 28742
    for id, boxes in list(labels.items())[::100]:
        lines = [line.split() for line in (folder / f"{id}.txt").read_text().splitlines()]
        real = [line for line in lines if line[0] != "DontCare"]
        assert boxes.category.tolist() == [line[0] for line in real]
        assert boxes.location.tolist() == [[float(x) for x in line[11:14]] for line in real]
        assert boxes.dimensions.tolist() == [[float(x) for x in line[8:11]] for line in real]
        assert boxes.rotation_y.tolist() == [float(line[14]) for line in real]


def test_a_label_folder_says_which_frame_is_missing(object_root: Path) -> None:
    folder = object_root / "training" / "label_2"
    assert list(read_label_folder(folder)) == ["000000", "000003"]
    assert list(read_label_folder(folder, ["000003"])) == ["000003"]
    with pytest.raises(DataError, match=r"000004\.txt"):
        read_label_folder(folder, ["000003", "000004"])
    with pytest.raises(ConfigurationError):
        read_label_folder(folder, ["../000003"])
    with pytest.raises(DataError, match="no such folder"):
        read_label_folder(folder / "absent")
