"""Pasting: stereo geometry measured by other means, gradients, and nothing changed outside."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from scipy import ndimage, optimize
from torch import Tensor

from avsec_gym.attacks.patch_files import Patch
from avsec_gym.attacks.patch_pasting import largest_area, paste, paste_on_frame
from avsec_gym.attacks.patch_placement import PatchPlace
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_images
from avsec_gym.rig import kitti_rig

HEIGHT, WIDTH = 375, 1242
CALIBRATION = kitti_rig().calibration


def frame(seed: int = 0, height: int = HEIGHT, width: int = WIDTH) -> SensorFrame:
    draw = np.random.default_rng(seed)
    images = {camera: draw.integers(0, 256, (height, width, 3), np.uint8) for camera in (2, 3)}
    return SensorFrame("000000", CALIBRATION, images)


def pair(seed: int = 0, height: int = 40, width: int = 90) -> StereoBatch:
    images = 255 * torch.rand(2, 1, 3, height, width, generator=torch.Generator().manual_seed(seed))
    return batch_of_images(images[0].double(), images[1].double(), [CALIBRATION])


def smooth(seed: int = 0) -> Tensor:
    """A texture that bilinear sampling hardly blurs."""
    noise = np.random.default_rng(seed).normal(size=(76, 76))
    wide = cv2.GaussianBlur(noise, (0, 0), 2)
    return torch.from_numpy(127 + 110 * np.tanh(wide / wide.std())).float().expand(3, -1, -1)


def crop(image: np.ndarray, u: int, v: int, half: int) -> np.ndarray:
    return image[v - half : v + half, u - half : u + half].mean(axis=2).astype(np.float64)


@pytest.mark.parametrize(
    ("disparity", "rotation"), [(10.0, 0.0), (23.37, 1.0), (41.5, 2.5), (76.81, 4.0)]
)
def test_the_patch_has_its_disparity(disparity: float, rotation: float) -> None:
    attacked = paste_on_frame(frame(), smooth(), PatchPlace(600.3, 180.7, disparity, rotation))
    whole = round(disparity)
    # Squares inside of the disc: nothing of the background speaks for any disparity.
    left, right = (crop(attacked.image(c), 600 - s, 181, 24) for c, s in ((2, 0), (3, whole)))

    def mismatch(shift: NDArray[np.float64]) -> float:
        moved = ndimage.shift(left, shift, order=3)
        return float(np.square(moved - right)[4:-4, 4:-4].mean())

    dv, du = optimize.minimize(mismatch, [0.0, 0.0], method="Nelder-Mead").x
    assert whole - du == pytest.approx(disparity, abs=0.02)
    assert dv == pytest.approx(0, abs=0.02)


def test_block_matching_finds_the_patch() -> None:
    attacked = paste_on_frame(frame(), smooth(3), PatchPlace(500.0, 200.0, 32.0, 0.7))
    grey = [np.rint(attacked.image(camera)).astype(np.uint8).mean(axis=2) for camera in (2, 3)]
    matcher = cv2.StereoSGBM.create(0, 64, 7, 8 * 49, 32 * 49)
    found = matcher.compute(*(image.astype(np.uint8) for image in grey)) / 16
    assert np.abs(found[180:220, 480:520] - 32).max() < 0.1


def test_both_views_change_and_only_within_the_disc() -> None:
    clean, place = frame(), PatchPlace(300.4, 100.8, 20.3, 0.4)
    attacked = paste_on_frame(clean, Patch.noise().pixels, place)
    v, u = np.mgrid[:HEIGHT, :WIDTH]
    for camera, centre in ((2, place.u), (3, place.u - place.disparity)):
        changed = (attacked.image(camera) != clean.image(camera)).any(axis=2)
        assert not changed[np.hypot(u - centre, v - place.v) >= place.radius].any()
        assert 0.97 * np.pi * 38**2 < changed.sum() <= largest_area(38) < 1.04 * np.pi * 38**2


def test_no_centre_touches_more_pixels_than_the_largest_area() -> None:
    for radius in (0.6, 1.0, 3.3, 38.0):
        v, u = np.mgrid[-45:46, -45:46]
        centres = np.random.default_rng(1).uniform(0, 1, (200, 2))
        touched = [(np.hypot(u - x, v - y) < radius).sum() for x, y in centres]
        assert max(touched) <= largest_area(radius)


def test_gradients_are_those_of_finite_differences() -> None:
    batch, place = pair(), PatchPlace(40.3, 18.6, 12.25, 0.8, radius=3)
    weights = torch.rand(2, 3, 40, 90, generator=torch.Generator().manual_seed(1)).double()

    def value(patch: Tensor) -> Tensor:
        pasted = paste(batch, patch, [place])
        return (weights * torch.cat([pasted.left, pasted.right])).sum()

    patch = (255 * torch.rand(3, 6, 6)).double().requires_grad_()
    assert torch.autograd.gradcheck(value, (patch,), eps=0.1)
    fine = (255 * torch.rand(3, 9, 9)).double().requires_grad_()
    assert torch.autograd.gradcheck(value, (fine,), eps=0.1)  # More texels than pixels.


def test_a_quarter_turn_turns_the_texture_clockwise() -> None:
    texture = torch.zeros(3, 12, 12)
    texture[:, :6, :] = 255  # The upper half is white.
    batch = pair()
    pasted = paste(batch, texture.double(), [PatchPlace(40, 20, 10.0, np.pi / 2, radius=6)])
    assert (pasted.left[0, :, 20, 42] == 255).all()
    assert (pasted.left[0, :, 20, 38] == 0).all()


def test_a_patch_of_the_pixels_own_size_is_seen_texel_by_texel() -> None:
    texture = Patch.noise(4, radius=6).pixels.double()
    pasted = paste(pair(), texture, [PatchPlace(39.5, 19.5, 10.0, radius=6)])
    assert torch.allclose(pasted.left[0, :, 17:23, 37:43], texture[:, 3:9, 3:9])
    assert torch.allclose(pasted.right[0, :, 17:23, 27:33], texture[:, 3:9, 3:9])


def test_a_pattern_pasted_small_is_averaged() -> None:
    stripes = torch.zeros(3, 76, 76).double()
    stripes[:, :, ::2] = 255
    pasted = paste(pair(), stripes, [PatchPlace(40.3, 20.1, 10.0, radius=8)])
    assert (pasted.left[0, :, 17:24, 37:44] - 127.5).abs().max() < 25


def test_a_patch_sticks_out_only_if_asked() -> None:
    batch, place = pair(), PatchPlace(84, 2, 10.0, radius=6)
    with pytest.raises(ConfigurationError, match="does not fit"):
        paste(batch, Patch.grey(6).pixels, [place])
    pasted = paste(batch, Patch.grey(6).pixels, [place], may_stick_out=True)
    assert (pasted.left[0, :, 0, 84] == 127.5).all()
    beyond = PatchPlace(8, 20, 30.0, radius=6)
    seen = paste(batch, Patch.grey(6).pixels, [beyond], may_stick_out=True)
    assert torch.equal(seen.right, batch.right)
    assert not torch.equal(seen.left, batch.left)


def test_each_pair_has_its_own_place() -> None:
    one = pair()
    two = batch_of_images(
        one.left.repeat(2, 1, 1, 1), one.right.repeat(2, 1, 1, 1), [CALIBRATION] * 2
    )
    places = [PatchPlace(30, 20, 10.0, radius=6), PatchPlace(60, 12, 20.0, radius=6)]
    pasted = paste(two, Patch.noise(radius=6).pixels, places)
    for i, place in enumerate(places):
        alone = paste(one, Patch.noise(radius=6).pixels, [place])
        assert torch.equal(pasted.left[i], alone.left[0])
        assert torch.equal(pasted.right[i], alone.right[0])
    with pytest.raises(ConfigurationError, match="as many patches"):
        paste(two, Patch.grey(6).pixels, places[:1])
