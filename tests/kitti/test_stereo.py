from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import DataError
from avsec_gym.kitti.check import check_data
from avsec_gym.kitti.layouts import KittiLayout
from avsec_gym.kitti.map_files import write_disparity
from avsec_gym.kitti.stereo import LAYOUTS, KittiStereo, StereoLayout

from .conftest import write_png


def make_stereo(root: Path, layout: StereoLayout) -> None:
    """Two pairs, the second one without truth, and an image after the first."""
    folder = root / "training"
    for kind in (layout.left, layout.right):
        for name in ("000000_10", "000000_11", "000001_10"):
            path = folder / kind / f"{name}.png"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(write_png(4, 3, bytes(range(36))))
    truth = np.full((3, 4), 7.5, np.float32)
    truth[0, 0] = np.nan
    write_disparity(folder / layout.truth["occ"] / "000000_10.png", truth)


@pytest.mark.parametrize("layout", LAYOUTS, ids=lambda layout: layout.name)
def test_both_benchmarks(tmp_path: Path, layout: StereoLayout) -> None:
    make_stereo(tmp_path, layout)
    for root in (tmp_path, tmp_path / "training"):
        data = KittiStereo(root)
        assert data.layout is layout
        assert data.ids() == ["000000_10", "000001_10"]
        assert data.ids(having=[layout.truth["occ"]]) == ["000000_10"]
    assert data.frame("000000_10").stereo().left.shape == (3, 4, 3)
    truth = data.disparity("000000_10")
    assert np.isnan(truth[0, 0])
    assert truth[2, 3] == 7.5
    with pytest.raises(DataError, match=f"000001_10 has no file in {layout.truth['occ']}"):
        data.disparity("000001_10")
    report = check_data(tmp_path, deep=True)
    assert report.layout is KittiLayout.STEREO
    assert report.ok
    assert f"training is of KITTI {layout.name}." in report.notes
    assert [(gap.lacks, gap.frames) for gap in report.gaps] == [
        (f"training/{layout.truth['occ']}", 1)
    ]


def test_the_object_layout_is_none(object_root: Path) -> None:
    with pytest.raises(DataError, match="Nothing of the KITTI stereo layouts"):
        KittiStereo(object_root)


def test_the_real_pairs(shared: Path) -> None:
    for name in ("stereo2012", "stereo2015"):
        data = KittiStereo(shared / "kitti" / name)
        (id,) = data.ids()
        frame = data.frame(id)
        assert frame.stereo().left.shape[:2] == data.disparity(id).shape
        assert check_data(shared / "kitti" / name, deep=True).ok
