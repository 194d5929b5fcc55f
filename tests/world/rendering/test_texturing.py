import numpy as np
import pytest

from avsec_gym.world.rendering.texturing import OverlayArrays, filtered_colour, overlay_colour
from avsec_gym.world.textures.library import TextureArrays

WHITE = 1.0


@pytest.fixture(scope="module")
def textures(build_library) -> TextureArrays:
    """A checkerboard (4 m x 2 m, tiles of 0.25 m), bars that run down (columns), and random."""
    row, column = np.mgrid[0:64, 0:128]
    checks = ((row // 8 + column // 8) % 2) * 255
    bars = (column // 4 % 2) * 255
    random = np.random.default_rng(0).integers(0, 256, (64, 64, 3))
    colours = [np.repeat(grey[..., None], 3, axis=2) for grey in (checks, bars)]
    pictures = [np.asarray(picture, np.uint8) for picture in (*colours, random)]
    names = ("checks", "bars", "random")
    sizes = ((4.0, 2.0), (4.0, 2.0), (2.0, 2.0))
    return build_library(list(zip(names, pictures, sizes, strict=True))).arrays


def colour(textures, index, u, v, short=(1e-4, 0.0), long=(0.0, 1e-4)) -> np.ndarray:
    values = [np.float32(value) for value in (u, v, *short, *long)]
    return np.array(filtered_colour(textures, index, *values))


def test_at_a_texels_middle_its_own_colour(textures: TextureArrays) -> None:
    """Row i, column j of the picture lies at v = (i + 1/2) / 32 m, u = (j + 1/2) / 32 m."""
    picture = textures.texels[textures.first[2, 0] :][: 64 * 64].reshape(64, 64, 3)
    for i, j in ((0, 0), (3, 50), (63, 63), (31, 0)):
        found = colour(textures, 2, (j + 0.5) / 32, (i + 0.5) / 32)
        np.testing.assert_allclose(found, (picture[i, j] / 255.0) ** 2.2, atol=2e-3)


def test_between_texels_a_mixture_in_linear_light(textures: TextureArrays) -> None:
    picture = (textures.texels[textures.first[2, 0] :][: 64 * 64].reshape(64, 64, 3) / 255) ** 2.2
    found = colour(textures, 2, 11.0 / 32, 20.75 / 32)
    upper, lower = picture[20, 10:12].mean(0), picture[21, 10:12].mean(0)
    np.testing.assert_allclose(found, 0.75 * upper + 0.25 * lower, atol=3e-3)


def test_textures_repeat_also_at_negative_places(textures: TextureArrays) -> None:
    rng = np.random.default_rng(1)
    for u, v in rng.uniform(0.0, 2.0, (20, 2)):
        here = colour(textures, 2, u, v)
        for repeats in (-3, -1, 5):
            there = colour(textures, 2, u + 2 * repeats, v - 2 * repeats)
            np.testing.assert_allclose(there, here, atol=2e-3)


def test_over_the_border_the_other_side_begins(textures: TextureArrays) -> None:
    picture = (textures.texels[textures.first[2, 0] :][: 64 * 64].reshape(64, 64, 3) / 255) ** 2.2
    corner = picture[[-1, -1, 0, 0], [-1, 0, -1, 0]].mean(axis=0)
    for u, v in ((0.0, 0.0), (2.0, 2.0), (-2.0, 4.0)):
        np.testing.assert_allclose(colour(textures, 2, u, v), corner, atol=3e-3)


@pytest.mark.parametrize("metres", [1.0, 3.0, 40.0])
def test_far_away_a_checkerboard_is_its_mean_light(textures: TextureArrays, metres: float) -> None:
    """Half white, half black is light 0.5 (not the middle grey value, which is light 0.22)."""
    for u in np.linspace(0.0, 1.0, 9):
        found = colour(textures, 0, u, 0.3 * u, (metres, 0.0), (0.0, metres))
        np.testing.assert_allclose(found, 0.5 * WHITE, atol=0.03)


def test_sharp_near_and_softer_farther(textures: TextureArrays) -> None:
    places = np.linspace(0.0, 1.0, 41)

    def contrast(pixel: float) -> float:
        light = [colour(textures, 0, u, 0.125, (pixel, 0.0), (0.0, pixel))[0] for u in places]
        return float(np.ptp(light))

    near, middle, far = (contrast(pixel) for pixel in (0.01, 0.36, 1.0))
    assert near > 0.98
    assert 0.02 < middle < 0.9
    assert far < 0.05


def test_at_grazing_angles_only_what_lies_across_the_view_blurs(textures: TextureArrays) -> None:
    """Bars of 0.125 m under a footprint of 0.03 m by 0.24 m, along the bars and across them."""
    places = np.linspace(0.0, 1.0, 65)
    along = [colour(textures, 1, u, 0.7, (0.03, 0.0), (0.0, 0.24))[0] for u in places]
    across = [colour(textures, 1, u, 0.7, (0.0, 0.03), (0.24, 0.0))[0] for u in places]
    assert np.ptp(along) > 0.95
    assert np.ptp(across) < 0.25
    np.testing.assert_allclose(np.mean(across), 0.5, atol=0.03)


def test_the_longer_axis_is_recognised_whatever_its_name(textures: TextureArrays) -> None:
    for u in np.linspace(0.0, 1.0, 9):
        one = colour(textures, 1, u, 0.7, (0.03, 0.0), (0.0, 0.24))
        two = colour(textures, 1, u, 0.7, (0.0, 0.24), (0.03, 0.0))
        np.testing.assert_allclose(one, two, atol=1e-5)


@pytest.fixture(scope="module")
def overlay() -> OverlayArrays:
    """20 m by 10 m at 10 pixels a metre from 5 m on; a white stripe at 12 to 13 m, half opaque
    red paint in the last half metre."""
    finest = np.zeros((100, 200, 4), np.float64)
    finest[:, 70:80] = 1.0
    finest[:, 195:] = [0.5, 0.0, 0.0, 0.5]
    levels = []
    level = finest
    for _ in range(4):
        levels.append(level)
        height, width = level.shape[0] // 2 * 2, level.shape[1] // 2 * 2
        level = level[:height, :width].reshape(height // 2, 2, width // 2, 2, 4).mean(axis=(1, 3))
    texels = [
        np.concatenate([255 * level[..., :3] ** (1 / 2.2), 255 * level[..., 3:]], -1).reshape(-1, 4)
        for level in levels
    ]
    sizes = [len(level) for level in texels]
    return OverlayArrays(
        (np.concatenate(texels) + 0.5).astype(np.uint8),
        np.cumsum([0, *sizes[:-1]]),
        np.array([level.shape[:2] for level in levels], np.int32),
        np.full(2, 10.0, np.float32),
        np.array([5.0], np.float32),
    )


def paint(overlay, u, v, short=(1e-3, 0.0), long=(0.0, 1e-3)) -> np.ndarray:
    values = [np.float32(value) for value in (u, v, *short, *long)]
    return np.array(overlay_colour(overlay, *values))


def test_paint_lies_where_it_was_painted(overlay: OverlayArrays) -> None:
    for u in (12.1, 12.5, 12.9):
        np.testing.assert_allclose(paint(overlay, u, 4.0), [1, 1, 1, 1], atol=0.01)
    for u in (11.9, 13.1, 8.0):
        np.testing.assert_allclose(paint(overlay, u, 4.0), 0.0, atol=0.01)
    assert paint(overlay, 12.0, 4.0)[3] == pytest.approx(0.5, abs=0.01)


def test_half_opaque_paint_brings_half_its_light(overlay: OverlayArrays) -> None:
    np.testing.assert_allclose(paint(overlay, 24.8, 5.0), [0.5, 0, 0, 0.5], atol=0.01)


def test_beyond_its_edges_there_is_no_paint(overlay: OverlayArrays) -> None:
    for u, v in ((4.0, 5.0), (26.0, 5.0), (12.5, -1.0), (12.5, 11.0)):
        np.testing.assert_array_equal(paint(overlay, u, v), 0.0)


def test_a_stripe_across_the_view_fades_as_its_share_of_the_footprint(
    overlay: OverlayArrays,
) -> None:
    """1 m of paint under 4 m of footprint: a quarter."""
    share = paint(overlay, 12.5, 5.0, (0.0, 0.2), (4.0, 0.0))
    np.testing.assert_allclose(share, 0.25, atol=0.06)
