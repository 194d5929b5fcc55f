from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.kitti.tracking import read_tracking_labels, write_tracking_labels

CAR = "Car 0 1 -1.85 733.06 182.54 934.34 317.95 1.45 1.49 3.79 2.73 1.60 9.79 -1.58"
REGION = "DontCare -1 -1 -10 579.4 175.8 595.0 188.1 -1000 -1000 -1000 -10 -1 -1 -1"
TEXT = (
    f"0 -1 {REGION}\n2 7 {CAR}\n2 -1 {REGION}\n2 9 {CAR.replace('Car 0', 'Person 2')}\n1 7 {CAR}\n"
)


def test_boxes_and_tracks_of_each_frame(tmp_path: Path) -> None:
    path = tmp_path / "0000.txt"
    path.write_text(TEXT)
    frames = read_tracking_labels(path)
    assert list(frames) == [0, 1, 2]
    assert [len(frame.boxes) for frame in frames.values()] == [0, 1, 2]
    assert frames[2].tracks.tolist() == [7, 9]
    assert frames[2].boxes.category.tolist() == ["Car", "Person"]
    assert frames[2].boxes.truncation is not None
    assert frames[2].boxes.truncation.tolist() == [0, -1]
    np.testing.assert_array_equal(frames[1].boxes.location, [[2.73, 1.60, 9.79]])
    everything = read_tracking_labels(path, keep_dont_care=True)
    assert everything[2].tracks.tolist() == [7, -1, 9]
    path.write_text("\n")
    assert read_tracking_labels(path) == {}


BROKEN = {
    "object label": (CAR, ":1: .*17 columns, this line 15"),
    "cut off": (TEXT[:-30], ":5: .*17 columns"),
    "result": (f"0 1 {CAR} 0.9", "this line 18"),
    "blank line": (f"0 1 {CAR}\n\n0 2 {CAR}", ":2: "),
    "no frame": (f"x 1 {CAR}", "'x 1'"),
    "before": (f"-1 1 {CAR}", "whole numbers"),
    "half a track": (f"0 1.5 {CAR}", "whole numbers"),
    "twice": (f"0 1 {CAR}\n0 1 {CAR}", ":2: Track 1 of frame 0 stands in line 1"),
    "word": (f"0 1 {CAR.replace('9.79', 'far')}", ":1: Column 16 holds 'far'"),
    "NaN": (f"0 0 {CAR}\n0 1 {CAR.replace('9.79', 'nan')}", ":2: Column 16.*not finite"),
    "no size": (f"0 1 {CAR.replace('1.45', '-1')}", "positive"),
}


@pytest.mark.parametrize(("text", "message"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_line_is_named(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "0000.txt"
    path.write_text(text)
    with pytest.raises(DataError, match=message) as caught:
        read_tracking_labels(path)
    assert caught.value.path == str(path)
    assert caught.value.remedy


def test_real_labels(shared: Path) -> None:
    frames = read_tracking_labels(shared / "kitti/tracking/training/label_02/0000.txt")
    assert len(frames) == 154
    van = [frame.boxes.location[frame.tracks == 0] for frame in frames.values()]
    places = np.concatenate(van)
    assert len(places) > 100
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 2  # It does not jump.


def test_labels_are_written_as_they_are_read(tmp_path: Path) -> None:
    path, again = tmp_path / "0000.txt", tmp_path / "0001.txt"
    path.write_text(TEXT)
    frames = read_tracking_labels(path)
    write_tracking_labels(again, frames)
    back = read_tracking_labels(again)
    assert list(back) == [1, 2], "a frame without objects has no line"
    assert back[2].tracks.tolist() == frames[2].tracks.tolist()
    np.testing.assert_array_equal(back[2].boxes.poses, frames[2].boxes.poses)
    np.testing.assert_array_equal(back[2].boxes.dimensions, frames[2].boxes.dimensions)
