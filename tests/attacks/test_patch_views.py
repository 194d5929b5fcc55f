"""The patch in the other camera: against OpenCV's projection of the poster as 3D points."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from scipy import ndimage, optimize

from avsec_gym.attacks.patch_pasting import paste, paste_on_frame
from avsec_gym.attacks.patch_placement import PatchPlace, PatchRange, random_place
from avsec_gym.attacks.patch_views import left_view, right_view
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.kitti.calibration import read_calibration
from avsec_gym.perception.stereo_batch import batch_of_frames
from avsec_gym.rig import kitti_rig

SIZE = (375, 1242)
SHIFTED = kitti_rig().calibration


def tilted(t_y: float = 0.05, t_z: float = -0.03) -> Calibration:
    """A rig whose right camera stands 5 cm lower and 3 cm farther ahead than the left one."""
    projections = SHIFTED.projections.copy()
    projections[3][:, 3] += projections[3][:, :3] @ [0.0, t_y, t_z]
    return replace(SHIFTED, projections=projections)


def poster(place: PatchPlace, calibration: Calibration) -> Floats:
    """Corners of the square around the disc, and its centre, as 3D points, shape (5, 3)."""
    p = calibration.projection(2)
    depth = calibration.focal_length(2) * calibration.baseline(2, 3) / place.disparity
    offsets = place.radius * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, 0]])
    pixels = offsets + np.array([place.u, place.v])
    rays = cv2.undistortPoints(pixels[:, None], p[:, :3], None)[:, 0]
    return calibration.camera_centre(2) + depth * np.column_stack([rays, np.ones(5)])


def error(place: PatchPlace, calibration: Calibration) -> float:
    """Pixels between the corners in the right image and OpenCV's, the largest."""
    left, right = calibration.projection(2), calibration.projection(3)
    view = right_view(place, left, right)
    here = poster(place, calibration) - calibration.camera_centre(3)
    seen = cv2.projectPoints(here, np.zeros(3), np.zeros(3), right[:, :3], None)[0][:, 0]
    offsets = place.radius * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [0, 0]])
    found = view.centre + offsets @ np.linalg.inv(view.to_left).T
    return float(np.abs(found - seen).max())


def places(calibration: Calibration, count: int = 20) -> list[PatchPlace]:
    nearest = PatchRange(nearest=5.0, farthest=40.0)
    return [random_place(calibration, SIZE, seed, range=nearest) for seed in range(count)]


@pytest.mark.parametrize(
    "calibration",
    [tilted(), tilted(-0.1, 0.0), tilted(0.0, 0.2)],
    ids=["both", "lower", "ahead"],
)
def test_corners_are_where_the_poster_is_seen(calibration: Calibration) -> None:
    assert max(error(place, calibration) for place in places(calibration)) < 0.01


def test_corners_are_where_the_poster_is_seen_by_every_real_pair(shared: Path) -> None:
    files = sorted((shared / "kitti/object/training/calib").glob("*.txt"))
    assert len(files) == 7481
    # Four pairs of cameras, one for each day of recording.
    different = {file.read_bytes(): file for file in files}
    assert len(different) > 1
    moved = []
    for calibration in map(read_calibration, different.values()):
        for place in places(calibration):
            assert error(place, calibration) < 0.01
            view = right_view(place, calibration.projection(2), calibration.projection(3))
            moved.append(np.abs(view.centre - [place.u - place.disparity, place.v]).max())
    assert max(moved) > 0.3, (
        "no real pair would distinguish a shift along the rows from a projection"
    )


def test_a_pair_that_differs_by_a_shift_alone_sees_exactly_the_shifted_disc() -> None:
    """Every bit: frames of the procedural world look as they did in earlier releases."""
    for place in places(SHIFTED):
        view = right_view(place, SHIFTED.projection(2), SHIFTED.projection(3))
        assert view.centre.tolist() == [place.u - place.disparity, place.v]
        assert view.to_left.tolist() == [[1.0, 0.0], [0.0, 1.0]]
        assert view.reach.tolist() == [place.radius, place.radius]


def test_images_scaled_for_a_network_show_it_at_the_same_place() -> None:
    calibration = tilted()
    place = places(calibration)[0]
    frame = SensorFrame(
        "000000", calibration, {camera: np.zeros((*SIZE, 3), np.uint8) for camera in (2, 3)}
    )
    batch = batch_of_frames([frame]).resized(SIZE[0] * 2, SIZE[1] * 2)
    scaled = PatchPlace(
        2 * place.u + 0.5, 2 * place.v + 0.5, 2 * place.disparity, 0.0, 2 * place.radius
    )
    projections = (batch.left_projection, batch.right_projection)
    view = right_view(scaled, *(each[0].numpy() for each in projections))
    here = right_view(place, calibration.projection(2), calibration.projection(3))
    # Not closer: c t_z stands in a baseline, and half a pixel of c is moved by the scaling.
    np.testing.assert_allclose(view.centre, 2 * here.centre + 0.5, atol=0.01)


def test_the_pasted_patch_is_seen_there() -> None:
    """The picture itself: which shift lays the left view over the right one."""
    calibration = tilted(0.06, 0.0)
    draw = np.random.default_rng(0)
    images = {camera: draw.integers(0, 256, (*SIZE, 3), np.uint8) for camera in (2, 3)}
    wide = cv2.GaussianBlur(draw.normal(size=(76, 76)), (0, 0), 2)
    texture = torch.from_numpy(127 + 110 * np.tanh(wide / wide.std())).float().expand(3, -1, -1)
    place = PatchPlace(600.3, 180.7, 40.0)
    attacked = paste_on_frame(SensorFrame("000000", calibration, images), texture, place)

    u, v = right_view(place, calibration.projection(2), calibration.projection(3)).centre
    column, row = round(u), round(v)
    assert row - 181 >= 4
    left = attacked.image(2)[157:205, 576:624].mean(axis=2)
    right = attacked.image(3)[row - 24 : row + 24, column - 24 : column + 24].mean(axis=2)

    def mismatch(shift: Floats) -> float:
        moved = ndimage.shift(left, shift, order=3)
        return float(np.square(moved - right)[4:-4, 4:-4].mean())

    down, across = optimize.minimize(mismatch, [0.0, 0.0], method="Nelder-Mead").x
    assert row + down - 181 == pytest.approx(v - 180.7, abs=0.02)
    assert column + across - 600 == pytest.approx(u - 600.3, abs=0.02)


def test_a_patch_that_only_the_right_image_cuts_off_is_refused_unasked() -> None:
    calibration = tilted(0.3, 0.0)
    images = {camera: np.zeros((*SIZE, 3), np.uint8) for camera in (2, 3)}
    batch = batch_of_frames([SensorFrame("000000", calibration, images)])
    low = PatchPlace(600.0, SIZE[0] - 1 - 38.0, 40.0)
    assert left_view(low).is_inside(*SIZE)
    with pytest.raises(ConfigurationError, match="does not fit"):
        paste(batch, torch.zeros(3, 76, 76), [low])
    assert paste(batch, torch.full((3, 76, 76), 255.0), [low], may_stick_out=True).right.any()
