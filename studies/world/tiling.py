"""Whether the road's texture repeats: seen from above, compared with itself some metres on."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.capture import Float32s, PinholeCamera, Renderer
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.site import Surface

LARGEST_REPEAT = 0.5
"""Correlation of the road's blotches with themselves a tile further on: below it none is seen."""

_VIEW, _HEIGHT, _SCALE = 700, 12.0, 0.02
_SMALLEST_LAG, _LARGEST_LAG = 0.6, 6.0
_GRAIN, _LEVEL, _PLAIN = 0.05, 0.3, 0.12
_COARSE, _STRIP = 35, 0.05


def texture_repeat(renderer: Renderer, posed: PosedScene) -> float | None:
    """The highest correlation of the road ahead with itself, moved by 0.6 to 6 m.

    Of its blotches: grains smaller than a decimetre are not distinguished from a car, and what runs
    along the road (wheel tracks, seams, dirt beside kerbs) is like itself anyway.

    Args:
        renderer: The renderer of the scene without actors.
        posed: The scene.

    Returns:
        In [-1, 1]; None where little of the view from above is plain road.
    """
    x, y, _ = posed.site.course.poses(12.0, 0.0)
    z = float(posed.site.ground.height(x, y)) + _HEIGHT
    to_world = np.eye(4)
    to_world[:3, :3] = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    to_world[:3, 3] = x, y, z
    middle = _VIEW / 2
    view = renderer.view(
        PinholeCamera(to_world, _HEIGHT / _SCALE, (middle, middle), (_VIEW, _VIEW))
    )
    grey = view.light.mean(axis=2)
    road = (view.geometry.surface == Surface.ROAD).astype(np.float32)
    plain: Float32s = road
    # Paint, drains and the edges of shadows may come back: they are no texture.  Nor is the
    # halo that they leave around them before they are known.
    for _ in range(2):
        level, blotches = (_mean_around(grey, plain, size) for size in (_LEVEL, _GRAIN))
        detail = np.asarray(blotches / (level + np.float32(1e-3)) - 1.0, np.float32)
        plain = np.asarray(plain * (np.abs(detail) < _PLAIN), np.float32)
    if plain.mean() < 0.1:
        return None
    detail = detail - _along_road(detail, plain, _left(posed, x, y))
    return round(_highest_repeat(detail * plain, plain), 4)


def _left(posed: PosedScene, x: float, y: float) -> Floats:
    """Metres from the course to the left, of each pixel of the view."""
    import cv2

    coarse = (np.arange(_COARSE) + 0.5) / _COARSE * _VIEW
    ahead, left = np.meshgrid(-(coarse - _VIEW / 2), -(coarse - _VIEW / 2), indexing="ij")
    _, result = posed.site.course.coordinates(x + ahead * _SCALE, y + left * _SCALE)
    return np.asarray(cv2.resize(result, (_VIEW, _VIEW), interpolation=cv2.INTER_LINEAR))


def _along_road(detail: Float32s, mask: Float32s, left: Floats) -> Float32s:
    """At each place the mean of all that lies as far to the left of the course."""
    strip = np.round((left - left.min()) / _STRIP).astype(np.int64).ravel()
    weight = np.bincount(strip, mask.ravel())
    total = np.bincount(strip, (detail * mask).ravel())
    return np.asarray((total / np.maximum(weight, 1.0))[strip].reshape(detail.shape), np.float32)


def _mean_around(values: Float32s, mask: Float32s, size: float) -> Float32s:
    """A blurred map that ignores what lies outside a mask."""
    import cv2

    total, weight = (cv2.GaussianBlur(m, (0, 0), size / _SCALE) for m in (values * mask, mask))
    return np.asarray(total / (weight + 1e-6))


def _highest_repeat(detail: Float32s, mask: Float32s) -> float:
    """Peak of the masked autocorrelation at the lags looked at."""
    size = 2 * _VIEW

    def correlation(values: Float32s) -> Floats:
        spectrum = np.fft.rfft2(values, (size, size))
        return np.fft.fftshift(np.fft.irfft2(np.abs(spectrum) ** 2, (size, size)))

    overlap = correlation(mask)
    power = float((detail**2).sum() / mask.sum())
    found = correlation(detail) / np.maximum(overlap, 1.0) / power
    rows, columns = np.indices(found.shape) - size // 2
    lag = np.hypot(rows, columns) * _SCALE
    looked_at = (lag > _SMALLEST_LAG) & (lag < _LARGEST_LAG) & (overlap > 0.2 * mask.sum())
    return float(found[looked_at].max())
