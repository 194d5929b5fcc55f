from __future__ import annotations

from pathlib import Path

import numpy as np
import pykitti
import pytest

from avsec_gym.errors import DataError
from avsec_gym.frame import Calibration
from avsec_gym.kitti.calibration import write_calibration
from avsec_gym.kitti.oxts import Oxts
from avsec_gym.kitti.oxts_poses import oxts_from_poses
from avsec_gym.kitti.tracking_sequences import KittiTracking, sequence_names

from .conftest import curve, write_png

CAR = "Car 0 1 -1.85 733.06 182.54 934.34 317.95 1.45 1.49 3.79 2.73 1.60 9.79 -1.58"


@pytest.fixture
def tracking_root(tmp_path: Path, rig: Calibration) -> Path:
    """Sequence 0004 with three frames, the scan of frame 1 lost, and 0011 with labels alone."""
    folder = tmp_path / "tracking" / "training"
    for kind in ("image_02/0004", "image_03/0004", "velodyne/0004", "label_02", "calib", "oxts"):
        (folder / kind).mkdir(parents=True)
    generator = np.random.default_rng(4)
    for number in range(3):
        for camera in ("image_02", "image_03"):
            pixels = generator.integers(0, 255, 36, np.uint8).tobytes()
            path = folder / camera / "0004" / f"{number:06d}.png"
            path.write_bytes(write_png(4, 3, pixels))
        if number != 1:
            scan = generator.uniform(0, 1, (5 + number, 4)).astype("<f4")
            scan.tofile(folder / "velodyne" / "0004" / f"{number:06d}.bin")
    write_calibration(folder / "calib" / "0004.txt", rig)
    (folder / "label_02" / "0004.txt").write_text(f"0 7 {CAR}\n2 7 {CAR}\n2 9 {CAR}\n")
    (folder / "label_02" / "0011.txt").write_text(f"0 1 {CAR}\n")
    write_table(folder / "oxts" / "0004.txt", oxts_from_poses(curve(3)))
    return folder.parent


def write_table(path: Path, oxts: Oxts) -> None:
    path.write_text("".join(" ".join(map(repr, row)) + "\n" for row in oxts.rows.tolist()))


def test_a_sequence_has_everything(tracking_root: Path, rig: Calibration) -> None:
    for root in (tracking_root, tracking_root / "training"):
        data = KittiTracking(root)
        assert data.sequences() == ["0004", "0011"]
        sequence = data.sequence("0004")
        assert sequence.sensors == {
            "image_02": (0, 1, 2),
            "image_03": (0, 1, 2),
            "velodyne": (0, 2),
        }
        assert sequence.frames(["image_02", "velodyne"]) == [0, 2]
    frame = sequence.frame(2)
    assert frame.id == "000002"
    assert len(frame.points) == 7
    assert [earlier.id for earlier in frame.previous] == ["000001", "000000"]
    assert not frame.previous[0].has_points
    assert frame.stereo().baseline == pytest.approx(rig.baseline())
    np.testing.assert_array_equal(sequence.calibration.projections, rig.projections)
    assert [len(sequence.labels(number)) for number in range(3)] == [1, 0, 2]
    assert sequence.tracks[2].tracks.tolist() == [7, 9]
    expected = curve(3)
    expected[:, :3, 3] -= expected[0, :3, 3].copy()
    np.testing.assert_allclose(sequence.poses, expected, rtol=0, atol=1e-6)


def test_pykitti_sees_the_same_pixels_and_points(
    tracking_root: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sequence = KittiTracking(tracking_root).sequence("0004")
    theirs = pykitti.tracking(str(tracking_root / "training"), "0004")
    for number in range(3):
        frame = sequence.frame(number)
        np.testing.assert_array_equal(frame.image(2), np.asarray(theirs.get_cam2(number)))
        np.testing.assert_array_equal(frame.image(3), np.asarray(theirs.get_cam3(number)))
    # pykitti counts the files that are there; the lost scan is the one between.
    np.testing.assert_array_equal(sequence.frame(0).points, theirs.get_velo(0))
    np.testing.assert_array_equal(sequence.frame(2).points, theirs.get_velo(1))
    assert "files 3" in capsys.readouterr().out


def test_what_lacks_is_named_when_it_is_asked_for(tracking_root: Path) -> None:
    data = KittiTracking(tracking_root)
    alone = data.sequence("0011")
    assert alone.frames() == []
    assert len(alone.labels(0)) == 1
    for ask in (lambda: alone.calibration, lambda: alone.oxts):
        with pytest.raises(DataError, match=r"sequence 0011 has no (calib|oxts)/0011.txt"):
            ask()
    with pytest.raises(DataError, match=r"There is no frame 5.*3 from 0 to 2"):
        data.sequence("0004").frame(5)
    with pytest.raises(DataError, match=r"There is no sequence 0001.*0004, 0011"):
        data.sequence("0001")
    with pytest.raises(DataError, match="Nothing of the KITTI tracking layout"):
        KittiTracking(tracking_root.parent)


def test_a_broken_line_of_oxts_is_named(tracking_root: Path) -> None:
    path = tracking_root / "training" / "oxts" / "0004.txt"
    path.write_text(path.read_text().rsplit(" ", 1)[0])
    with pytest.raises(DataError, match=r"0004.txt:3: .*30 numbers, this one 29"):
        _ = KittiTracking(tracking_root).sequence("0004").oxts


def test_the_object_layout_is_none(object_root: Path) -> None:
    assert sequence_names(object_root / "training") == []


def test_the_real_labels_and_calibrations(shared: Path) -> None:
    data = KittiTracking(shared / "kitti/tracking")
    assert len(data.sequences()) == 21
    for name in data.sequences():
        sequence = data.sequence(name)
        assert sequence.calibration.baseline() == pytest.approx(0.53, abs=0.02)
        assert sum(len(sequence.labels(number)) for number in sequence.tracks) > 100
