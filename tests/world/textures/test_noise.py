import numpy as np
import pytest

from avsec_gym.world.textures.noise import coloured, fractal_noise, picture, white_noise

SMOOTH = {
    "blurred": lambda rng: white_noise(rng, 96, 160, blur=4.0),
    "clouds": lambda rng: fractal_noise(rng, 96, 160, cells=5, octaves=3),
    "upright": lambda rng: fractal_noise(rng, 160, 64, cells=3, octaves=2),
    "small": lambda rng: white_noise(rng, 32, 24, blur=3.0),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_noise_runs_on_over_its_borders(name: str) -> None:
    """The step from the last row to the first is like any other step."""
    noise = SMOOTH[name](np.random.default_rng(3))
    for axis in (0, 1):
        steps = np.roll(noise, -1, axis) - noise
        seam = np.take(steps, [-1], axis)
        assert np.abs(seam).max() <= 1.5 * np.abs(steps).max()
        assert seam.std() < 1.6 * steps.std()


@pytest.mark.parametrize("name", [*SMOOTH, "white"])
def test_noise_has_mean_0_and_deviation_1_and_comes_from_its_generator(name: str) -> None:
    make = (SMOOTH | {"white": lambda rng: white_noise(rng, 64, 64)})[name]
    noise = make(np.random.default_rng(3))
    assert abs(float(noise.mean())) < 0.05
    assert float(noise.std()) == pytest.approx(1.0, abs=0.05)
    np.testing.assert_array_equal(noise, make(np.random.default_rng(3)))
    assert not np.array_equal(noise, make(np.random.default_rng(4)))


def test_octaves_add_detail_and_blur_takes_it() -> None:
    def roughness(noise: np.ndarray) -> float:
        return float(np.abs(np.diff(noise, axis=1)).mean())

    few, many = (
        fractal_noise(np.random.default_rng(0), 128, 128, octaves=count) for count in (1, 6)
    )
    assert roughness(many) > 1.4 * roughness(few)
    sharp, soft = (white_noise(np.random.default_rng(0), 128, 128, blur=b) for b in (1.0, 6.0))
    assert roughness(sharp) > 3 * roughness(soft)


def test_an_octave_has_about_its_number_of_cells() -> None:
    """Smooth noise of n cells changes its sign about n times."""
    noise = fractal_noise(np.random.default_rng(1), 256, 256, cells=16, octaves=1)
    crossings = (np.diff(np.sign(noise), axis=1) != 0).sum(axis=1).mean()
    assert 6 < crossings < 20


def test_colours_are_rounded_and_clipped() -> None:
    values = coloured((100, 200, 50), np.array([[-2.0, 0.0, 2.0]]), 0.5)
    np.testing.assert_array_equal(picture(values), [[[0, 0, 0], [100, 200, 50], [200, 255, 100]]])
    assert picture([[[0.4, 0.6, 254.6]]]).tolist() == [[[0, 1, 255]]]
