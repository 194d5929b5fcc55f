"""Places: inside both images, above the ground, in front of what they cover, in their third."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.attacks.patch_ghosts import ghost_box, target_boxes
from avsec_gym.attacks.patch_placement import (
    PatchPlace,
    PatchRange,
    random_place,
    specific_place,
)
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import box_corners, project
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.intention import Intention

SIZE = HEIGHT, WIDTH = 375, 1242
CALIBRATION = kitti_rig().calibration
FOCAL_LENGTH, CENTRE_U, HORIZON = 721.5377, 609.5593, 172.854
BASELINE = CALIBRATION.baseline()
SEEDS = range(300)


def car(x: float, z: float) -> Boxes3D:
    return Boxes3D([[x, 1.65, z]], [[1.5, 1.6, 4]], [-np.pi / 2], [1.0], ["Car"])


def depth(place: PatchPlace) -> float:
    return FOCAL_LENGTH * BASELINE / place.disparity


def test_random_places_are_whole_and_physical_and_everywhere() -> None:
    places = [random_place(CALIBRATION, SIZE, seed) for seed in SEEDS]
    for place in places:
        assert place.is_inside(HEIGHT, WIDTH)
        assert 8 - 1e-9 <= depth(place) <= 20 + 1e-9
        lowest_point = (place.v + place.radius - HORIZON) / FOCAL_LENGTH * depth(place)
        assert lowest_point <= 1.65 + 1e-9, "nothing stands below the ground"
    turned = np.degrees([place.rotation for place in places])
    assert -15 <= turned.min() < -13
    assert 13 < turned.max() <= 15
    u, v = np.array([[place.u, place.v] for place in places]).T
    assert u.min() < 80
    assert u.max() > 1180
    assert v.min() < 45
    assert v.max() > 275, "lower ones would have to be nearer than 8 m"
    assert len({place.intention(WIDTH) for place in places}) == 3


@pytest.mark.parametrize("intention", list(Intention))
def test_specific_places_are_in_the_third_of_the_intention(intention: Intention) -> None:
    first = {Intention.LEFT: 0, Intention.STRAIGHT: 414, Intention.RIGHT: 828}[intention]
    for seed in SEEDS:
        place = specific_place(intention, CALIBRATION, SIZE, seed)
        assert first - 0.5 <= place.u < first + 413.5
        assert place.intention(WIDTH) == intention
        assert place.is_inside(HEIGHT, WIDTH)


def test_a_centre_beside_the_image_belongs_to_the_third_next_to_it() -> None:
    assert PatchPlace(-9.0, 180, 30.0).intention(WIDTH) is Intention.LEFT
    assert PatchPlace(WIDTH + 9.0, 180, 30.0).intention(WIDTH) is Intention.RIGHT


@pytest.mark.parametrize(
    ("u", "v", "inside"),
    [
        (15, 10, True), (189, 89, True), (14.9, 50, False), (189.1, 50, False), (100, 9.9, False),
        (100, 89.1, False),
    ],
)  # fmt: skip
def test_a_patch_is_inside_up_to_its_rim_in_both_images(u: float, v: float, inside: bool) -> None:
    assert PatchPlace(u, v, disparity=5.0, radius=10.0).is_inside(100, 200) is inside


def test_an_unknown_intention_is_an_error() -> None:
    with pytest.raises(ConfigurationError, match="intention"):
        specific_place(None, CALIBRATION, SIZE, 0)


def test_equal_seeds_draw_equal_places() -> None:
    assert random_place(CALIBRATION, SIZE, [1, 2]) == random_place(CALIBRATION, SIZE, [1, 2])
    assert random_place(CALIBRATION, SIZE, [1, 2]) != random_place(CALIBRATION, SIZE, [1, 3])


def test_a_patch_stands_in_front_of_what_it_covers() -> None:
    # 8 m ahead, 60 m wide and higher than the image: every patch covers it.
    wall = Boxes3D([[0, 1.65, 8]], [[9, 0.2, 60]], [0.0], [1.0], ["Misc"])
    for seed in SEEDS:
        place = random_place(CALIBRATION, SIZE, seed, objects=wall)
        reachable = place.u - place.radius >= FOCAL_LENGTH * BASELINE / 7.9
        assert not reachable or depth(place) <= 7.9 + 1e-6
    beside = random_place(CALIBRATION, SIZE, 5, objects=car(-200, 8))
    assert beside == random_place(CALIBRATION, SIZE, 5)


def test_images_without_room_are_an_error() -> None:
    with pytest.raises(ConfigurationError, match="no room"):
        random_place(CALIBRATION, (70, 400), 0)
    with pytest.raises(ConfigurationError, match="no room"):
        random_place(CALIBRATION, (375, 80), 0)


@pytest.mark.parametrize(
    "wrong",
    [{"disparity": 0.0}, {"disparity": -20.0}, {"radius": 0.0}, {"radius": -1.0}, {"u": np.nan}],
)
def test_impossible_places_are_errors(wrong: dict[str, float]) -> None:
    with pytest.raises(ConfigurationError):
        PatchPlace(**({"u": 100.0, "v": 100.0, "disparity": 20.0} | wrong))
    with pytest.raises(ConfigurationError):
        PatchRange(nearest=10, farthest=5)
    for tilt in (0.0, 181.0, np.nan):
        with pytest.raises(ConfigurationError, match="tilt"):
            PatchRange(tilt=tilt)
    for tilt in (0.5, 180.0):
        assert PatchRange(tilt=tilt).steepest == pytest.approx(np.radians(tilt))


def test_the_ghost_is_seen_where_the_patch_is_in_both_views() -> None:
    for seed in SEEDS:
        place = random_place(CALIBRATION, SIZE, seed)
        ghost = ghost_box(place, CALIBRATION)
        corners = box_corners(ghost.location, ghost.dimensions, ghost.rotation_y)[0]
        assert ghost.location[0, 1] <= 1.65 + 1e-9
        for camera, u in ((2, place.u), (3, place.u - place.disparity)):
            pixels, z = project(CALIBRATION.projection(camera), corners)
            rear = pixels[np.argsort(z)[:4]]
            assert rear[:, 0].mean() == pytest.approx(u, abs=1e-6)
            assert rear[:, 1].min() < place.v < rear[:, 1].max()
        assert np.sort(z)[0] == pytest.approx(depth(place), rel=1e-6), "its rear is the patch"


def test_the_ghost_is_no_wider_than_the_patch_and_no_larger_than_a_car() -> None:
    widths = []
    for metres in (8.0, 12.0, 15.0, 20.0, 40.0):
        ghost = ghost_box(PatchPlace(610, 180, FOCAL_LENGTH * BASELINE / metres), CALIBRATION)
        height, width, length = ghost.dimensions[0]
        assert (height / width, length / width) == pytest.approx((1.53 / 1.63, 3.88 / 1.63))
        widths.append(width)
    # A disc of 76 pixels is 1.63 m wide from 15.5 m on.
    assert widths == pytest.approx([76 * z / FOCAL_LENGTH for z in (8, 12, 15)] + [1.63, 1.63])


def test_the_ghost_of_a_low_patch_stands_on_the_ground() -> None:
    ghost = ghost_box(PatchPlace(700, 240, 30.0), CALIBRATION)
    assert ghost.location[0, 1] == pytest.approx(1.65)
    x = (700 - CENTRE_U) / FOCAL_LENGTH * FOCAL_LENGTH * BASELINE / 30
    # The boxes' frame is that of camera 0, which is 6 cm right of camera 2.
    assert ghost.location[0, 0] == pytest.approx(x + CALIBRATION.camera_centre(2)[0], abs=1e-6)


def test_targets_keep_the_real_objects_that_can_still_be_seen() -> None:
    place = PatchPlace(610, 220, 30.0)
    ghost = ghost_box(place, CALIBRATION)
    x, _, z = ghost.location[0]
    same_place, elsewhere = car(x + 0.3, z + 1), car(-8, 20)
    # Its middle, 0.75 m above the ground, is seen 39 rows below the horizon: behind the disc.
    hidden = car(x, FOCAL_LENGTH * 0.9 / 39)
    targets = target_boxes(place, CALIBRATION, Boxes3D.concatenate([same_place, elsewhere, hidden]))
    assert targets.location == pytest.approx(np.concatenate([elsewhere.location, ghost.location]))
    assert target_boxes(place, CALIBRATION).location == pytest.approx(ghost.location)
    assert target_boxes(place, CALIBRATION, Boxes3D.empty()).location == pytest.approx(
        ghost.location
    )


def test_targets_keep_what_labels_say_of_hidden_objects() -> None:
    label = replace(
        car(-8, 20), box2d=[[1, 2, 3, 4]], truncation=[0.0], occlusion=[3.0], alpha=[0.0]
    )
    targets = target_boxes(PatchPlace(610, 220, 30.0), CALIBRATION, label)
    assert targets.occlusion is not None
    assert targets.occlusion.tolist() == [3, 0]
