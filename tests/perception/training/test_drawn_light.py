"""Light that is drawn: what views share, and how far they may differ."""

from __future__ import annotations

import numpy as np

from avsec_gym.perception.training.configuration import Photometric
from avsec_gym.perception.training.drawn_light import drawn_light

_LIMITS = Photometric(
    brightness=0.3, contrast=0.2, gamma=0.1, saturation=0.4, tint=0.05, noise=6.0, between_views=0.5
)
_LARGEST = np.array([0.3, 0.2, 0.1, 0.4, 0.05, 0.05, 0.05])


def test_views_differ_by_no_more_than_their_share_and_light_keeps_its_limits() -> None:
    randomness = np.random.default_rng(0)
    lights = [drawn_light(_LIMITS, randomness) for _ in range(200)]
    common = np.array([light.common for light in lights])
    apart = np.array([light.of_view(randomness) - light.common for light in lights])
    np.testing.assert_array_less(np.abs(common).max(axis=0), _LARGEST)
    np.testing.assert_array_less(np.abs(apart).max(axis=0), 0.5 * _LARGEST)
    # Both go to either side, nearly as far as they may.
    for drawn, largest in ((common, _LARGEST), (apart, 0.5 * _LARGEST)):
        assert (drawn.max(axis=0) > 0.9 * largest).all()
        assert (drawn.min(axis=0) < -0.9 * largest).all()
    deviations = [light.deviation for light in lights]
    assert 0.0 <= min(deviations) < 1.0
    assert 5.0 < max(deviations) <= 6.0
