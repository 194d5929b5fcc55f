"""`avsec world show` of files whose sizes do not fit each other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.kitti.calibration import write_calibration
from avsec_gym.kitti.labels import write_labels
from avsec_gym.kitti.map_files import write_disparity, write_mask
from avsec_gym.kitti.sensor_files import write_image
from avsec_gym.rig import kitti_rig

SIZE = (60, 200)
WRITERS = {
    "image_3": lambda path, size: write_image(path, np.zeros((*size, 3), np.uint8)),
    "disparity_2": lambda path, size: write_disparity(path, np.ones(size, np.float32)),
    "surface_2": lambda path, size: write_mask(path, np.zeros(size, np.uint8)),
}


@pytest.mark.parametrize("other", [None, *WRITERS])
@pytest.mark.parametrize("size", [(60, 198), (58, 200)])
def test_what_stands_beside_an_image_has_its_size(
    other: str | None, size: tuple[int, int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, out = tmp_path / "training", tmp_path / "picture.png"
    write_labels(folder / "label_2" / "000001.txt", Boxes3D.empty())
    write_calibration(folder / "calib" / "000001.txt", kitti_rig().calibration)
    write_image(folder / "image_2" / "000001.png", np.zeros((*SIZE, 3), np.uint8))
    for name, write in WRITERS.items():
        write(folder / name / "000001.png", size if name == other else SIZE)
    code = run(["world", "show", str(tmp_path), "--out", str(out)])
    error = capsys.readouterr().err
    assert code == (0 if other is None else 1), error
    assert out.is_file() == (other is None)
    if other is not None:
        assert f"{folder / other / '000001.png'}: " in error
        assert f"{size[1]} x {size[0]} pixels" in error
