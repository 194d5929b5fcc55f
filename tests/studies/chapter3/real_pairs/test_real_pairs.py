"""Lights in pairs whose noise is known, from judge to page."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.experiments.json_rows import row_of
from avsec_gym.frame import SensorFrame
from avsec_gym.rig import kitti_rig
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitted_on import fitted_on
from avsec_gym.validation.thresholds import ThresholdTable, read_threshold_table
from studies.chapter3.real_pairs import judge, page
from studies.chapter3.real_pairs.disc_light import (
    MEAN_OF_PEAK,
    PairDifference,
    brightest_disc,
    pair_difference,
)
from studies.chapter3.real_pairs.result import RealPairsResult

SHAPE = (120, 400)


def noise(seed: int = 0, deviation: float = 5.0) -> PairDifference:
    values = np.random.default_rng(seed).normal(0, deviation, SHAPE).astype(np.float32)
    return PairDifference(values, np.ones(SHAPE, bool))


def test_the_mean_of_a_facula_over_its_disc() -> None:
    rows, columns = np.ogrid[-100:101, -100:101]
    squared = (rows**2 + columns**2) / 100**2
    light = np.exp(-2.0 * squared)[squared <= 1]
    assert light.mean() == pytest.approx(MEAN_OF_PEAK, rel=0.01)


@pytest.mark.parametrize("radius", [3.0, 7.9, 25.0])
def test_the_brightest_disc_is_that_of_all_discs(radius: float) -> None:
    difference = noise()
    reach = int(radius)
    rows, columns = np.ogrid[-reach : reach + 1, -reach : reach + 1]
    disc = rows**2 + columns**2 <= radius**2
    windows = np.lib.stride_tricks.sliding_window_view(difference.residual, disc.shape)
    means = (
        windows[:, :, disc].mean(axis=2)
        if radius < 8
        else np.array(
            [
                [windows[v, u][disc].mean() for u in range(0, windows.shape[1], 4)]
                for v in range(0, windows.shape[0], 4)
            ]
        )
    )
    found = brightest_disc(difference, radius)
    # Discs at the border, which are half within, have larger means.
    assert found >= 0.9 * np.abs(means).max()
    assert found < 6 * 5.0 / np.sqrt(0.5 * disc.sum())
    assert difference.pixel_noise == pytest.approx(5.0, rel=0.05)


def test_a_disc_that_is_not_known_has_no_mean() -> None:
    nothing = PairDifference(np.zeros(SHAPE, np.float32), np.zeros(SHAPE, bool))
    assert (brightest_disc(nothing, 10.0), nothing.pixel_noise) == (0.0, 0.0)
    lit = noise()
    rows, columns = np.ogrid[: SHAPE[0], : SHAPE[1]]
    inside = (rows - 60) ** 2 + (columns - 200) ** 2 <= 20**2
    shown = PairDifference(np.where(inside, np.float32(40), lit.residual), lit.known)
    assert brightest_disc(shown, 20.0) == pytest.approx(40, rel=0.1)
    hidden = PairDifference(np.where(inside, np.float32(0), lit.residual), lit.known & ~inside)
    assert brightest_disc(hidden, 20.0) < 5


def pair(seed: int, blotch: float = 0.0) -> SensorFrame:
    """A wall of dots 14 m ahead; a surface that shines into the left camera only."""
    random = np.random.default_rng(seed)
    dots = random.integers(60, 90, (160, 460, 1)).repeat(3, axis=2)
    left, right = (dots[:, start : start + 400] for start in (0, 28))
    left = left + blotch * np.exp(-2 * _squared(left.shape[:2], 60, 300, 25))[..., None]
    images = {
        camera: np.clip(np.rint(image + random.normal(0, 2, image.shape)), 0, 255).astype(np.uint8)
        for camera, image in ((2, left), (3, right))
    }
    return SensorFrame("0", kitti_rig().calibration, images)


def _squared(shape: tuple[int, ...], v: int, u: int, radius: float) -> np.ndarray:
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    return ((rows - v) ** 2 + (columns - u) ** 2) / radius**2


def test_noise_and_light_of_a_pair_are_found() -> None:
    depth = PairDepth()
    clean = judge.seen_pair(pair(0), depth)
    # Of two images with a deviation of 2 and means of three colours.
    assert clean.difference.pixel_noise == pytest.approx(2 * np.sqrt(2 / 3), rel=0.3)
    lit = Facula(2, 80.0, (200.0, 80.0), 40.0).attack(pair(0)).frame
    radius = 80.0 * 400 / 1242
    found = pair_difference(lit, depth.estimator(lit.calibration, 2, 3).disparity(lit).values)
    assert brightest_disc(found, radius) == pytest.approx(40 * MEAN_OF_PEAK, rel=0.2)
    assert clean.disc(80.0) < 2


@pytest.fixture
def made(tmp_path: Path) -> RealPairsResult:
    root = tmp_path / "kitti/object/training"
    for number in range(4):
        for camera in (2, 3):
            path = root / f"image_{camera}" / f"{number:06d}.png"
            path.parent.mkdir(parents=True, exist_ok=True)
            image = pair(number, 110.0 * (number == 2)).image(camera)
            assert cv2.imwrite(str(path), image[..., ::-1])
    on = fitted_on(LIDAR_AND_TWO_CAMERAS, PairDepth(), kitti_rig().calibration,
                   {"recording": "walls", "frames": 1})  # fmt: skip
    (tmp_path / "fits").mkdir()
    table = ThresholdTable(on, np.array([[[0.2, 0.2, 0.2, 0.001]]]))
    table.write(tmp_path / "fits/own.thresholds.json")
    words = [
        *("--kitti", str(tmp_path / "kitti"), "--draws", "2", "--radii", "160", "--strengths"),
        *("2", "160", "--thresholds", str(tmp_path / "fits/own.thresholds.json")),
        *("--fits", str(tmp_path / "fits"), "--json", str(tmp_path / "found.json")),
    ]
    assert judge.main(words) == 0
    found = row_of(RealPairsResult, json.loads((tmp_path / "found.json").read_text()))
    raised = read_threshold_table(tmp_path / "fits/own.thresholds.json")
    assert raised.least_brightness == found.raised.value
    # To do it again does not raise by what was raised.
    assert judge.main(words) == 0
    assert row_of(RealPairsResult, json.loads((tmp_path / "found.json").read_text())) == found
    return found


def test_one_real_pair_shines_and_raises_the_threshold_for_the_others(
    made: RealPairsResult, tmp_path: Path
) -> None:
    shining = max(made.pairs, key=lambda pair: pair.brightness)
    assert shining.id.endswith("000002")
    assert (made.raised.value, made.raised.clusters) == (shining.brightness, 4)
    assert made.raised.vouched == pytest.approx(1 - 0.05 ** (1 / 4))
    assert shining.brightness > made.rendered == 0.001
    # By the others alone the shining one is an alarm; by all of them none is.
    assert [pair.id for pair in made.pairs if pair.alarms["raised"]] == [shining.id]
    assert made.false_alarms["rendered"].count == 1
    [floor] = made.floors
    assert floor.noise < 1 < floor.floor.value
    assert floor.peak == pytest.approx(floor.floor.value / MEAN_OF_PEAK)
    faint, strong = made.lights
    assert faint.strength < floor.peak < strong.strength
    assert faint.detected["rendered"].count <= 2
    for rule in ("raised", "discs"):
        assert strong.detected[rule].count >= faint.detected[rule].count + 2, rule
    assert page.main([str(tmp_path / "found.json"), "--out", str(tmp_path / "page.md")]) == 0
    text = (tmp_path / "page.md").read_text()
    assert text == page.real_pairs_page(made)
    assert "1 of 4 lie above it" in text
    assert "| 2 (below) |" in text
    assert "| 160 |" in text


def test_no_draws(tmp_path: Path) -> None:
    assert judge.main(["--kitti", str(tmp_path), "--draws", "0"]) == 1
