import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.world.rendering.image_sensor import (
    GAMMA,
    ImageSensor,
    draw_sensors,
    metered_exposure,
    tone_curve,
)
from avsec_gym.world.rendering.light import Light, draw_light
from avsec_gym.world.rendering.shading import sky_colour


def test_the_sun_stands_where_it_is_said_to() -> None:
    sun = Light(azimuth=np.pi / 2, elevation=np.radians(30)).sun
    np.testing.assert_allclose(sun, [0.0, np.sqrt(0.75), 0.5], atol=1e-6)


def test_a_low_sun_is_dimmer_and_redder_and_clouds_hide_it() -> None:
    low, high = (Light(elevation=angle, cloudiness=0.0).sun_colour for angle in (0.2, 1.2))
    assert (low < high).all()
    assert low[0] / low[2] > 1.2 * high[0] / high[2]
    clear, overcast = (Light(cloudiness=share).sun_colour for share in (0.0, 1.0))
    assert (overcast < 0.15 * clear).all()


def test_the_sky_is_brighter_at_the_horizon_and_around_the_sun() -> None:
    light = Light(azimuth=1.0, elevation=0.7, cloudiness=0.0)
    panorama = light.panorama
    assert np.isfinite(panorama).all()
    assert panorama.min() > 0
    rows = panorama.mean(axis=(1, 2))
    assert rows[:8].mean() > 1.3 * rows[-8:].mean()
    row = int(np.sin(0.7) * 96)
    column = (1.0 + np.pi) / (2 * np.pi) * 512
    assert abs(panorama[row].mean(axis=-1).argmax() - column) < 20
    # The kernels look the sun's direction up in the same place.
    towards = np.array(sky_colour(panorama, *light.sun))
    away = np.array(sky_colour(panorama, -light.sun[0], -light.sun[1], light.sun[2]))
    assert (towards > 1.2 * away).all()


def test_the_sky_has_no_seam_behind() -> None:
    panorama = Light(cloudiness=0.5, seed=4, azimuth=2.0).panorama
    seam = np.abs(panorama[:, 0] - panorama[:, -1])
    inside = np.abs(np.diff(panorama, axis=1))
    assert seam.max() <= 1.5 * inside.max()
    one, two = (sky_colour(panorama, -1.0, y, 0.3) for y in (1e-4, -1e-4))
    np.testing.assert_allclose(one, two, rtol=0.02)


def test_daylights_vary_within_bounds_and_come_from_their_generator() -> None:
    lights = [draw_light(np.random.default_rng(seed)) for seed in range(300)]
    assert all(np.radians(15) < light.elevation < np.radians(70) for light in lights)
    assert all(0.25 < light.brightness < 0.55 and light.haze > 300 for light in lights)
    assert 0.3 < np.mean([light.cloudiness < 0.3 for light in lights]) < 0.9
    assert np.std([np.cos(light.azimuth) for light in lights]) > 0.6
    assert draw_light(np.random.default_rng(7)).seed == lights[7].seed
    assert len({light.seed for light in lights}) == 300


@given(st.floats(0.05, 0.8), st.integers(0, 2**31), st.floats(-4.0, 4.0))
def test_the_exposure_gives_the_mean_that_is_aimed_for(
    brightness: float, seed: int, stops: float
) -> None:
    light = np.random.default_rng(seed).lognormal(stops, 0.7, (200, 3)).astype(np.float32)
    exposed = light * np.float32(metered_exposure(light, brightness))
    assert float(tone_curve(np.clip(exposed, 0, 1)).mean()) == pytest.approx(brightness, abs=2e-3)


def test_the_tone_curve_runs_from_black_to_white() -> None:
    values = tone_curve(np.linspace(0, 1, 50, dtype=np.float32))
    assert values[0] == 0.0
    assert values[-1] == 1.0
    assert (np.diff(values) > 0).all()


def test_a_sensor_keeps_the_light_level_and_adds_the_noise_it_says() -> None:
    grey = np.full((80, 120, 3), 0.4, np.float32)
    sharp = ImageSensor(blur=0.0, smoothing=0.0, read_noise=0.01, shot_noise=0.001)
    image = sharp.expose(grey, np.random.default_rng(0)) / 255.0
    signal = image**GAMMA
    assert signal.mean() == pytest.approx(0.4, abs=3e-3)
    assert signal.std() == pytest.approx(np.sqrt(0.01**2 + 0.001 * 0.4), rel=0.1)
    gained = ImageSensor(gain=(1.2, 1.0, 0.8)).expose(grey, np.random.default_rng(0))
    red, green, blue = ((gained / 255.0) ** GAMMA).mean(axis=(0, 1))
    np.testing.assert_allclose([red / green, blue / green], [1.2, 0.8], rtol=0.02)
    assert ImageSensor().expose(9 * grey, np.random.default_rng(0)).min() == 255
    assert ImageSensor().expose(0 * grey, np.random.default_rng(0)).max() < 8


def test_blur_spreads_an_edge_over_pixels_without_moving_it() -> None:
    step = np.zeros((40, 60, 3), np.float32)
    step[:, 30:] = 0.8
    quiet = {"read_noise": 0.0, "shot_noise": 0.0, "glare": 0.0}
    sharp, soft = (
        (ImageSensor(blur=b, smoothing=0.0, **quiet).expose(step, np.random.default_rng(0)) / 255)
        ** GAMMA
        for b in (0.0, 1.5)
    )
    profile, blurred = sharp[20, :, 1], soft[20, :, 1]
    assert set(np.round(np.unique(profile), 2)) == {0.0, 0.8}
    assert ((blurred > 0.05) & (blurred < 0.75)).sum() >= 4
    assert blurred.sum() == pytest.approx(profile.sum(), rel=0.01)


def test_cameras_of_one_rig_differ_a_little() -> None:
    sensors = draw_sensors(np.random.default_rng(0), 6)
    gains = np.array([sensor.gain for sensor in sensors])
    assert len({sensor.gain for sensor in sensors}) == 6
    assert 0.005 < gains.std() < 0.1
    assert draw_sensors(np.random.default_rng(0), 6) == sensors


def test_dazzling_light_blooms_and_leaves_the_rest_of_the_light_level_alone() -> None:
    quiet = {"read_noise": 0.0, "shot_noise": 0.0, "blur": 0.0, "smoothing": 0.0}
    light = np.full((96, 160, 3), 0.2, np.float32)
    light[44:52, 76:84] = 12.0
    plain, blooming = (
        (ImageSensor(**quiet, **lens).expose(light, np.random.default_rng(0)) / 255) ** GAMMA
        for lens in ({"glare": 0.0, "streaks": 0.0}, {})
    )
    gained = (blooming - plain)[..., 1]
    assert gained[48, 90] > gained[60, 96] > gained[4, 4] - 0.01
    assert gained[48, 90] > 0.01
    # Streaks lie along rows and columns: more there than as far off on the diagonal.
    assert gained[48, 110] > gained[48 + 21, 80 + 21]


def test_a_resampled_sensor_has_the_noise_of_averaged_pixels() -> None:
    sensor = ImageSensor(read_noise=0.01, shot_noise=0.001, smoothing=0.0, blur=0.0)
    grey = np.full((80, 120, 3), 0.4, np.float32)
    full, half = (
        camera.expose(grey, np.random.default_rng(0)).std()
        for camera in (sensor, sensor.resampled(0.5))
    )
    assert half == pytest.approx(0.5 * full, rel=0.1)
