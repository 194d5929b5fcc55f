from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image as Pillow

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.map_files import read_disparity, read_mask, write_disparity, write_mask

Png = Callable[..., bytes]
disparities = st.floats(0, 255.875, width=32) | st.just(float("nan"))
fixture = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)


@fixture
@given(arrays(np.float32, (3, 5), elements=disparities))
def test_disparities_come_back_to_half_a_step(tmp_path: Path, disparity: np.ndarray) -> None:
    path = tmp_path / "000000_10.png"
    write_disparity(path, disparity, overwrite=True)
    again = read_disparity(path)
    assert again.dtype == np.float32
    np.testing.assert_array_equal(np.isnan(again), np.isnan(disparity))
    known = ~np.isnan(disparity)
    assert (again[known] > 0).all()
    expected = np.maximum(disparity[known], 1 / 256)
    np.testing.assert_allclose(again[known], expected, rtol=0, atol=1 / 512)
    write_disparity(path, again, overwrite=True)
    np.testing.assert_array_equal(read_disparity(path), again)


def test_the_file_is_as_kitti_says(tmp_path: Path) -> None:
    """16 bits, disparity times 256, 0 where unknown; read by Pillow."""
    path = tmp_path / "000000_10.png"
    write_disparity(path, np.array([[np.nan, 1.0, 200.5]], np.float32))
    np.testing.assert_array_equal(np.asarray(Pillow.open(path)), [[0, 256, 51328]])
    with pytest.raises(DataError, match="exists"):
        write_disparity(path, np.ones((1, 1), np.float32))


@pytest.mark.parametrize(
    "disparity", [np.ones(3), np.ones((2, 2, 1)), [[-0.1]], [[np.inf]], [[256.0]], np.ones((0, 4))]
)
def test_what_the_format_cannot_say_is_refused(tmp_path: Path, disparity: np.ndarray) -> None:
    with pytest.raises(ConfigurationError):
        write_disparity(tmp_path / "map.png", np.asarray(disparity, np.float32))
    assert not list(tmp_path.iterdir())


@fixture
@given(
    arrays(st.sampled_from([np.uint8, np.uint16]), st.tuples(st.integers(1, 6), st.integers(1, 6)))
)
def test_masks_come_back(tmp_path: Path, mask: np.ndarray) -> None:
    write_mask(tmp_path / "mask.png", mask, overwrite=True)
    again = read_mask(tmp_path / "mask.png")
    assert again.dtype == mask.dtype
    np.testing.assert_array_equal(again, mask)


def test_masks_are_checked(tmp_path: Path) -> None:
    for mask in (np.ones((2, 2)), np.ones((2, 2, 3), np.uint8), np.ones((2, 2), np.int32)):
        with pytest.raises(ConfigurationError):
            write_mask(tmp_path / "mask.png", mask)


def test_a_broken_map_is_named(tmp_path: Path, png: Png) -> None:
    path = tmp_path / "map.png"
    write_mask(path, np.ones((9, 9), np.uint8))
    with pytest.raises(DataError, match="8 bits, a disparity map 16"):
        read_disparity(path)
    write_disparity(path, np.ones((9, 9), np.float32), overwrite=True)
    whole = path.read_bytes()
    for content, message in (
        (b"", "empty"),
        (whole[:-20], "cut off"),
        (whole[:45] + b"x" + whole[46:], "damaged"),
        (png(4, 3), "colour type 2"),
        (png(2, 3, bytes(36), bits=16), "16 bits a channel in colour type 2"),
    ):
        path.write_bytes(content)
        for read in (read_disparity, read_mask):
            with pytest.raises(DataError, match=message) as caught:
                read(path)
            assert caught.value.path == str(path)
            assert caught.value.remedy


@pytest.mark.parametrize(
    ("name", "known"),
    [("stereo2012/training/disp_occ", 0.358), ("stereo2015/training/disp_occ_0", 0.191)],
)
def test_real_maps(shared: Path, tmp_path: Path, name: str, known: float) -> None:
    path = shared / "kitti" / name / "000000_10.png"
    disparity = read_disparity(path)
    assert np.isfinite(disparity).mean() == pytest.approx(known, abs=1e-3)
    assert 4 < np.nanmin(disparity) < np.nanmax(disparity) < 70
    write_disparity(tmp_path / "map.png", disparity)
    with Pillow.open(tmp_path / "map.png") as ours, Pillow.open(path) as theirs:
        np.testing.assert_array_equal(np.asarray(ours), np.asarray(theirs))


def test_a_real_map_warps_the_right_image_onto_the_left(shared: Path) -> None:
    """Pixels u - d of the right image look like pixels u of the left one."""
    from avsec_gym.kitti.sensor_files import read_image

    folder = shared / "kitti/stereo2015/training"
    left, right = (read_image(folder / f"image_{i}/000000_10.png").astype(float) for i in (2, 3))
    disparity = read_disparity(folder / "disp_occ_0/000000_10.png")
    v, u = np.nonzero(np.isfinite(disparity))
    there = np.round(u - disparity[v, u]).astype(int)
    v, u, there = v[there >= 0], u[there >= 0], there[there >= 0]
    matched = np.abs(left[v, u] - right[v, there]).mean()
    assert matched < 0.6 * np.abs(left[v, u] - right[v, u]).mean()
