"""Where a camera is damaged, on a smooth wall that three cameras and a scan see alike."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.validation.evidence.brightness import equally_exposed
from avsec_gym.validation.repair.localisation import damaged_pixels
from avsec_gym.validation.repair.trusted_view import filled_depth, trusted_depth, trusted_view

TRUSTED: dict[int, list[tuple[Sensor, ...]]] = {
    0: [(1, 2), (LIDAR, 1)],
    1: [(0, 2), (LIDAR, 2, 0)],
    2: [(LIDAR, 0)],
}
SPOT = Facula(radius=180.0, centre=(130.0, 60.0), saturation=0.3)
"""35 pixels of this wall."""


@pytest.mark.parametrize(
    ("camera", "trusted"), [(camera, each) for camera in TRUSTED for each in TRUSTED[camera]]
)
def test_a_facula_is_found_where_it_is_and_nowhere_without_it(
    soft_wall: SensorFrame, camera: int, trusted: tuple[Sensor, ...]
) -> None:
    assert not damaged_pixels(soft_wall, camera, trusted).any()
    tampered = Facula(camera, SPOT.radius, SPOT.centre, saturation=0.3).attack(soft_wall)
    found, true = damaged_pixels(tampered.frame, camera, trusted), tampered.pixels[camera]
    assert (found & true).sum() > 0.85 * (found | true).sum()


def test_what_is_darkened_is_found_too(soft_wall: SensorFrame) -> None:
    image = soft_wall.image(0).copy()
    image[40:80, 100:150] = 0
    found = damaged_pixels(soft_wall.with_image(0, image), 0, (1, 2))
    assert found[45:75, 105:145].all()
    assert not found[:, :90].any()
    assert not found[:, 160:].any()


def test_exposure_is_no_damage_and_light_on_most_of_the_image_no_exposure(
    soft_wall: SensorFrame,
) -> None:
    brighter = (soft_wall.image(0) * 1.3).astype(np.uint8)
    assert not damaged_pixels(soft_wall.with_image(0, brighter), 0, (1, 2)).any()
    brighter[:, 80:] += 60
    frame = soft_wall.with_image(0, brighter)
    # Two thirds of the image are lit.
    view = trusted_view(frame, 0, (1, 2))
    expected = equally_exposed(view.image, brighter, view.believed).least
    ratio = expected[10:-10, 30:70].mean() / soft_wall.image(0)[10:-10, 30:70].mean()
    assert ratio == pytest.approx(1.3, abs=0.03)
    assert damaged_pixels(frame, 0, (1, 2))[:, 85:].mean() > 0.9


def test_a_grey_camera_is_compared_without_colours(soft_wall: SensorFrame) -> None:
    frame = soft_wall
    for camera in (1, 2):
        frame = frame.with_image(
            camera, (soft_wall.image(camera) * [1.5, 1.0, 0.5]).astype(np.uint8)
        )
    assert not damaged_pixels(frame, 0, (1, 2)).any()


def test_someone_must_be_trusted(soft_wall: SensorFrame) -> None:
    for trusted in ((), (1,), (LIDAR,), (0, 1)):
        with pytest.raises(ConfigurationError):
            trusted_view(soft_wall, 0, trusted)


@pytest.mark.parametrize("camera", [0, 1])
def test_beyond_half_a_kilometre_all_looks_the_same(soft_wall: SensorFrame, camera: int) -> None:
    """Cameras that see the same in the same columns look at what is infinitely far away."""
    frame = soft_wall
    for other in (1, 2):
        frame = frame.with_image(other, soft_wall.image(0))
    np.testing.assert_array_equal(trusted_depth(frame, camera, (1, 2)), 500.0)


def test_gaps_in_depth_take_the_background() -> None:
    depth = np.full((40, 90), np.nan, np.float32)
    depth[:, :30], depth[:, 60:] = 5.0, 20.0
    filled = filled_depth(depth)
    np.testing.assert_array_equal(filled[:, 30:38], 5.0)
    np.testing.assert_array_equal(filled[:, 40:], 20.0)
    depth[:20] = np.nan
    assert np.isfinite(filled_depth(depth)).all()
