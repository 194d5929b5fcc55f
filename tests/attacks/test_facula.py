"""Faculae: a Gaussian of the stated radius, cut off at white, in one camera and nowhere else."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from avsec_gym.attacks.facula import THESIS_RADII, Facula
from avsec_gym.attacks.optical_attack import OpticalAttack
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig

SIZE = (375, 1242)


def frame_of(level: int | tuple[int, int, int] = 90, size: tuple[int, int] = SIZE) -> SensorFrame:
    image = np.full((*size, 3), level, np.uint8)
    return SensorFrame("0", kitti_rig().calibration, {2: image, 3: image}, np.ones((5, 4), "f4"))


@pytest.mark.parametrize("saturation", [0.0, 0.4])
def test_a_gaussian_against_a_plain_loop(saturation: float) -> None:
    random = np.random.default_rng(0)
    frame = frame_of(size=(40, 124))
    frame.images[2][:] = random.integers(0, 256, frame.images[2].shape)
    colour, centre, radius = (1.0, 0.5, 0.1), (60.3, 21.6), 150.0
    attack = Facula(2, radius, centre, 200.0, colour, saturation)
    tampered = attack.attack(frame)
    own_radius = radius * 124 / 1242
    core = saturation * own_radius
    deviation = math.sqrt((own_radius**2 - core**2) / 4)
    for row in range(40):
        for column in range(124):
            away = math.hypot(column - centre[0], row - centre[1])
            for channel in range(3):
                light = 200 * colour[channel]
                light *= math.exp(-(away**2 - core**2) / (2 * deviation**2))
                if away <= core:
                    light = 255.0
                before = int(frame.image(2)[row, column, channel])
                expected = min(255.0, before + light)
                assert abs(tampered.frame.image(2)[row, column, channel] - expected) <= 0.5 + 1e-3
            assert not (tampered.pixels[2][row, column] and away > own_radius)
    assert tampered.frame.image(2).dtype == np.uint8


@pytest.mark.parametrize(
    ("radius", "percent"),
    [(37.5, 0.95), (75, 3.79), (112.5, 8.54), (150, 15.18), (187.5, 23.71), (225, 34.15)],
)
def test_contaminated_areas_are_those_of_the_thesis(radius: float, percent: float) -> None:
    # Higher than KITTI's images, which a disc of 225 pixels does not fit into.
    frame = frame_of(size=(480, 1242))
    changed = Facula(2, radius, (620.3, 240.7)).attack(frame).pixels[2]
    assert 100 * changed.sum() / (1242 * 375) == pytest.approx(percent, abs=0.01)


def test_the_same_share_of_other_sizes() -> None:
    for height, width in ((370, 1224), (376, 1241), (188, 621)):
        pixels = Facula(radius=75, centre=(width / 2, height / 2)).attack(
            frame_of(size=(height, width))
        )
        area = np.pi * (75 * width / 1242) ** 2
        assert pixels.pixels[2].sum() == pytest.approx(area, rel=0.01)


def test_the_thesis_draws_size_and_place() -> None:
    assert Facula().radius == THESIS_RADII == (187, 375)
    small = frame_of(size=(38, 124))
    settings = [Facula().attack(small, seed).settings for seed in range(60)]
    radius, u, v = (np.array([each[key] for each in settings]) for key in ("radius", "u", "v"))
    for values, low, high in ((radius, *THESIS_RADII), (u, 0, 123), (v, 0, 37)):
        assert low <= values.min() < low + 0.1 * (high - low)
        assert high >= values.max() > high - 0.1 * (high - low)
    # To give the place leaves the size that is drawn, and the other way round.
    assert Facula(centre=(3, 4)).attack(small, 7).settings["radius"] == radius[7]
    assert Facula(radius=80).attack(small, 7).settings["u"] == u[7]


def test_the_middle_is_drawn_on_a_pixel() -> None:
    alone = frame_of(size=(1, 1))
    places = [Facula().attack(alone, seed).settings for seed in range(5)]
    assert [(each["u"], each["v"]) for each in places] == [(0.0, 0.0)] * 5


def test_the_seed_decides_and_nothing_else_is_touched() -> None:
    frame = frame_of()
    before = frame.image(2).copy()
    one, two = Facula().attack(frame, [3, 1]), Facula().attack(frame, [3, 1])
    assert one.frame.image(2).tobytes() == two.frame.image(2).tobytes()
    assert one.frame.image(2).tobytes() != Facula().attack(frame, 4).frame.image(2).tobytes()
    np.testing.assert_array_equal(frame.image(2), before)
    assert one.frame.image(3) is frame.image(3)
    assert one.frame.points is frame.points
    assert one.attacked == Facula().sensors == {2}
    assert isinstance(Facula(), OpticalAttack)


def test_a_saturated_core_is_white_in_a_green_halo() -> None:
    attack = Facula(2, 100.0, (600, 180), 250.0, (0.0, 1.0, 0.0), saturation=0.5)
    image = attack.attack(frame_of((20, 21, 20))).frame.image(2)
    assert (image[180, 551:650] == 255).all()
    halo = image[180, 655:690].astype(int)
    assert (halo[:, 1] > 60).all()
    assert (halo[:, [0, 2]] == 20).all()
    assert (np.diff(halo[:, 1]) <= 0).all()


def test_a_grey_camera_stays_grey() -> None:
    colour = (0.0, 1.0, 0.2)
    grey = Facula(centre=(600, 180), colour=colour).attack(frame_of(50)).frame.image(2)
    assert (grey[..., :1] == grey).all()
    tinted = Facula(centre=(600, 180), colour=colour).attack(frame_of((50, 50, 51)))
    assert not (tinted.frame.image(2)[..., 0] == tinted.frame.image(2)[..., 1]).all()


def test_what_was_white_is_not_changed() -> None:
    frame = frame_of()
    frame.images[2][:100] = 255
    tampered = Facula(radius=300, centre=(600, 180), strength=1000.0).attack(frame)
    assert tampered.frame.image(2).min() >= 90, "light adds, and does not wrap around"
    assert not tampered.pixels[2][:100].any()
    assert tampered.pixels[2][100:, 600].all()


def test_images_of_attacks_may_have_parts_of_grey_levels() -> None:
    frame = frame_of().with_image(2, np.full((*SIZE, 3), 10.25, np.float32))
    image = Facula(radius=50, centre=(600, 180)).attack(frame).frame.image(2)
    assert image.dtype == np.float32
    assert image[0, 0, 0] == 10.25


@pytest.mark.parametrize(
    "bad",
    [
        {"camera": -1},
        {"camera": True},
        {"camera": 2.0},
        {"radius": 0},
        {"radius": (5, 3)},
        {"radius": float("nan")},
        {"centre": (np.inf, 0)},
        {"strength": 0},
        {"colour": (0, 0, 0)},
        {"colour": (1, 1)},
        {"saturation": 1},
        {"saturation": -0.1},
    ],
)
def test_what_cannot_be_is_refused(bad: dict[str, Any]) -> None:
    with pytest.raises(ConfigurationError):
        Facula(**bad)


def test_a_missing_camera_is_an_error() -> None:
    with pytest.raises(DataError, match="camera 0"):
        Facula(0).attack(frame_of())


def test_a_camera_may_be_a_number_of_an_array() -> None:
    assert Facula(np.int64(2)).attack(frame_of()).attacked == {2}  # type: ignore[arg-type]
