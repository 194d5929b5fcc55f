"""Texture replacement on a plane whose texture is known everywhere."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from avsec_gym.attacks.side_area import Roadside, RoadView
from avsec_gym.attacks.texture import Replacement, replace_texture
from avsec_gym.attacks.texture_complexity import texture_complexity
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig

CALIBRATION = kitti_rig().calibration
HEIGHT, WIDTH, HORIZON = 375, 1242, 173
PARALLAX = CALIBRATION.focal_length() * CALIBRATION.baseline()
P = CALIBRATION.projection()


def plane(camera: int, half_width: float = 4.0):
    """Place of every pixel of the ground in metres, and its view: a straight road, verges."""
    v, u = np.indices((HEIGHT, WIDTH), dtype=float)
    below = v > HORIZON + 8
    depth = np.where(below, P[1, 1] * 1.65 / np.maximum(v - P[1, 2], 1), np.inf)
    disparity = np.where(below, PARALLAX / depth, 0).astype(np.float32)
    left_u = u + disparity * (camera == 3)
    x = np.where(below, (left_u - P[0, 2]) * np.where(below, depth, 0) / P[0, 0], 0)
    road = below & (np.abs(x) < half_width)
    return x, depth, RoadView(road, below & ~road, disparity)


def noise(x, z, roughness, seed):
    """Grain of 0.1 m on the ground plane: the same point, the same grey."""
    grain = np.random.default_rng(seed).normal(0, roughness, (1024, 1024)).astype(np.float32)
    along = np.log(np.where(np.isfinite(z), z, 1)) / 0.015
    place = ((values % 1000).astype(np.float32) for values in (x / 0.1, along))
    return cv2.remap(grain, *place, cv2.INTER_LINEAR)


@pytest.fixture(scope="module")
def scene():
    images, views = {}, []
    for camera in (2, 3):
        x, z, view = plane(camera)
        grey = np.full(x.shape, 200.0)
        grey[view.road] = (90 + noise(x, z, 4, 0))[view.road]
        grey[view.side] = (70 + noise(x, z, 16, 1))[view.side]
        images[camera] = np.repeat(np.rint(grey).clip(0, 255)[..., None], 3, 2).astype(np.uint8)
        views.append(view)
    return SensorFrame("000000", CALIBRATION, images), Roadside(*views)


def test_only_the_side_area_and_the_edge_of_the_road_change(scene):
    frame, roadside = scene
    result = replace_texture(frame, roadside, 1)
    for camera, view in ((2, roadside.left), (3, roadside.right)):
        changed = (result.image(camera) != frame.image(camera)).any(2)
        assert result.image(camera).dtype == np.uint8
        assert changed[view.side].mean() > 0.9
        assert not changed[~(view.side | view.road)].any()
        x, _, _ = plane(camera)
        assert not changed[view.road & (np.abs(x) < 3.5)].any()


def test_the_side_area_gets_the_roads_look(scene):
    frame, roadside = scene
    result = replace_texture(frame, roadside, 1)
    # At one distance: what is far looks busier in the image.
    band = np.zeros((HEIGHT, WIDTH), bool)
    band[240:280] = True
    road = texture_complexity(frame.image(), roadside.left.road & band)
    side = texture_complexity(frame.image(), roadside.left.side & band)
    for camera, view in ((2, roadside.left), (3, roadside.right)):
        now = texture_complexity(result.image(camera), view.side & band)
        assert side.deviation > 3 * road.deviation
        assert now.deviation == pytest.approx(road.deviation, rel=0.3)
        assert now.gradient == pytest.approx(road.gradient, rel=0.3)
    new = result.image()[roadside.left.side]
    assert new.mean() == pytest.approx(frame.image()[roadside.left.road].mean(), abs=1)


def test_both_views_show_one_texture_at_the_true_disparity(scene):
    """A point of the plane has the same grey in both views, and another one a shift apart."""
    frame, roadside = scene
    result = replace_texture(frame, roadside, 1)
    rows, columns = np.nonzero(roadside.left.side)
    near = rows > 250
    rows, columns = rows[near], columns[near]
    left = result.image(2)[rows, columns, 0].astype(float)

    def mismatch(shift):
        place = columns - roadside.left.disparity[rows, columns] + shift
        inside = (place > 0) & (place < WIDTH - 2)
        before = np.floor(place[inside]).astype(int)
        share = place[inside] - before
        image, row = result.image(3)[..., 0].astype(float), rows[inside]
        right = (1 - share) * image[row, before] + share * image[row, before + 1]
        return np.abs(left[inside] - right).mean()

    assert mismatch(0) < 1.0
    assert mismatch(6) > 2 * mismatch(0)
    assert mismatch(-6) > 2 * mismatch(0)


def test_cells_fade_into_each_other(scene):
    """A road that is light and dark in long waves gives a roadside without seams."""
    frame, roadside = scene
    images = {}
    for camera, view in ((2, roadside.left), (3, roadside.right)):
        x, _, _ = plane(camera)
        grey = np.where(view.road, 100 + 40 * np.sin(x / 2), frame.image(camera)[..., 0])
        images[camera] = np.repeat(np.rint(grey)[..., None], 3, 2).astype(np.uint8)
    result = replace_texture(replace(frame, images=images), roadside, 1).image(2)[..., 0]
    # Away from the road's edge, and where a pixel is a small part of a wave.
    within = roadside.left.side[250:, 1:] & roadside.left.side[250:, :-1]
    within &= np.abs(plane(2)[0][250:, 1:]) > 5.5
    steps = np.abs(np.diff(result[250:].astype(int)))[within]
    assert within.sum() > 20_000
    assert steps.max() <= 6


def test_the_same_seed_gives_the_same_pixels_and_another_one_others(scene):
    frame, roadside = scene
    one, again, other = (replace_texture(frame, roadside, seed) for seed in ([3, 1], [3, 1], 4))
    np.testing.assert_array_equal(one.image(3), again.image(3))
    assert (one.image(3) != other.image(3)).mean() > 0.2


def test_paint_on_the_road_is_not_copied(scene):
    frame, roadside = scene
    painted = frame
    for camera in (2, 3):
        x, _, view = plane(camera)
        image = frame.image(camera).copy()
        image[view.road & (np.abs(x - 1.0) < 0.1)] = 250
        painted = painted.with_image(camera, image)
    side = replace_texture(painted, roadside, 1).image()[roadside.left.side]
    assert (side > 160).mean() < 0.001


def test_grey_has_no_texture(scene):
    frame, roadside = scene
    result = replace_texture(frame, roadside, replacement=Replacement.GREY_ON_SIDE)
    colours = np.unique(result.image()[roadside.left.side], axis=0)
    assert len(colours) == 1
    assert colours[0, 0] == pytest.approx(90, abs=2)
    assert texture_complexity(result.image(), roadside.left.side).gradient == 0


def test_the_reverse_control_roughens_the_road_alone(scene):
    frame, roadside = scene
    result = replace_texture(frame, roadside, replacement="side_on_road")
    view = roadside.left
    before, after = (texture_complexity(f.image(), view.road) for f in (frame, result))
    assert after.deviation > 3 * before.deviation
    np.testing.assert_array_equal(result.image()[~view.road], frame.image()[~view.road])


def test_shuffling_alone_keeps_the_complexity(scene):
    frame, roadside = scene
    result = replace_texture(frame, roadside, replacement="side_on_side")
    before, after = (
        texture_complexity(f.image(), roadside.left.side).deviation for f in (frame, result)
    )
    assert after == pytest.approx(before, rel=0.25)


def test_what_cannot_be_done_is_refused(scene):
    frame, roadside = scene
    with pytest.raises(ConfigurationError, match="no replacement"):
        replace_texture(frame, roadside, replacement="gold")
    small = RoadView(*(np.zeros((10, 10), kind) for kind in (bool, bool, np.float32)))
    with pytest.raises(ConfigurationError, match="masks"):
        replace_texture(frame, Roadside(small, small))
    nothing = RoadView(
        np.zeros_like(roadside.left.road), roadside.left.side, roadside.left.disparity
    )
    with pytest.raises(DataError, match="road"):
        replace_texture(frame, Roadside(nothing, nothing))


def test_no_texture_is_taken_from_what_the_other_view_hides(scene):
    """A nearer surface of the same kind stands before all of it in the right view."""
    frame, roadside = scene
    nearer = replace(roadside.right, disparity=roadside.right.disparity + 2)
    with pytest.raises(DataError, match="only 0 rows of the image show the road in both views"):
        replace_texture(frame, replace(roadside, right=nearer))


def test_complexity_of_a_known_pattern():
    ramp = np.repeat(np.arange(0, 200, 2, dtype=np.uint8)[None], 60, 0)
    image = np.repeat(ramp[..., None], 3, 2)
    region = np.zeros(ramp.shape, bool)
    region[10:40, 20:80] = True
    measured = texture_complexity(image, region)
    assert measured.gradient == pytest.approx(2.0, rel=1e-3)
    assert measured.deviation == pytest.approx(2 * np.std(np.arange(7)), rel=1e-3)
    assert measured.pixels == (30 - 6) * (60 - 6)
    assert np.isnan(texture_complexity(image, np.zeros_like(region)).gradient)
