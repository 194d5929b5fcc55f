"""Maps of a wall of random dots, which three cameras and a scan see alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.brightness import brightness_inconsistency, without_colours
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.evidence import (
    evidence_elements,
    evidence_scopes,
    gather_evidence,
)
from avsec_gym.validation.evidence.pair_depth import PairDepth

SYSTEM = SensorSystem((LIDAR, 2, 1, 0))
DEPTH = 8.0
PAIRS = {(0, 2): 40, (1, 2): 40, (0, 3): 80, (1, 3): 120, (2, 3): 80}
"""Focal length times baseline of each."""


@pytest.fixture(scope="module")
def wall(wall_of: Callable[[int], SensorFrame]) -> SensorFrame:
    return wall_of(0)


@pytest.mark.parametrize("pair", PAIRS)
def test_every_pair_sees_the_wall_where_it_is(wall: SensorFrame, pair: tuple[int, int]) -> None:
    found = DisparityMaps(wall, SYSTEM)[pair]
    assert found.focal_times_baseline == pytest.approx(PAIRS[pair])
    # The leftmost columns of the wall are out of the other camera's sight.
    inner = found.depth[10:-10, 40:-10]
    assert np.isfinite(inner).mean() > (0.1 if pair[0] == 0 else 0.9)
    np.testing.assert_allclose(np.nanmedian(inner), DEPTH, rtol=0.02)


def test_a_pair_is_matched_once_and_only_if_asked_for(
    wall: SensorFrame, monkeypatch: pytest.MonkeyPatch
) -> None:
    matched = []
    find = DisparityMaps._find
    monkeypatch.setattr(
        DisparityMaps, "_find", lambda self, pair: matched.append(pair) or find(self, pair)
    )
    errors = DisparityErrors(DisparityMaps(wall, SYSTEM))
    assert not matched
    assert errors[0, 1, 3] is errors[0, 1, 3]
    assert sorted(matched) == [(0, 3), (1, 3)]
    errors.maps.find(SYSTEM.pairs())
    assert sorted(matched) == sorted(SYSTEM.pairs())


def test_brightness_is_found_with_the_maps_the_longest_work_first(
    wall: SensorFrame, monkeypatch: pytest.MonkeyPatch
) -> None:
    between = [pair for pair in SYSTEM.pairs() if pair[0] > 0]
    maps = DisparityMaps(wall, SYSTEM)
    found = []
    find = DisparityMaps._find
    monkeypatch.setattr(
        DisparityMaps, "_find", lambda self, pair: found.append(pair) or find(self, pair)
    )
    maps.find(SYSTEM.pairs(), threads=1)
    # Cameras 2 and 0 are 60 cm from each other, 1 and 0 40 cm, 2 and 1 20 cm.
    assert found[:3] == [(1, 3), (2, 3), (1, 2)]
    for i, k in between:
        images = (wall.image(int(SYSTEM.sensors[sensor])) for sensor in (k, i))
        assert maps.brightness((i, k)) == brightness_inconsistency(*images, maps[i, k].values)
    maps.find(SYSTEM.pairs())
    assert len(found) == 5
    with pytest.raises(ConfigurationError, match="LiDAR sees no brightness"):
        maps.brightness((0, 3))
    for pair in ((3, 2), (1, 4), (1, 0)):
        with pytest.raises(ConfigurationError, match="are those of"):
            maps.find([(2, 3), pair])


def test_sound_sensors_agree_and_a_covered_one_is_found(wall: SensorFrame) -> None:
    errors = DisparityErrors(DisparityMaps(wall, SYSTEM))
    assert all(errors[triple].error < 0.02 for triple in SYSTEM.triples)
    covered = wall.image(1).copy()
    covered[:, 80:180] = 255
    errors = DisparityErrors(DisparityMaps(wall.with_image(1, covered), SYSTEM))
    for triple in SYSTEM.triples:
        one = errors[triple]
        # A hole where the matcher admits it, a wrong disparity where it does not.
        assert (one.error + one.hole_share > 0.3) == (2 in triple), triple


def test_evidence_is_in_the_order_of_its_scopes(wall: SensorFrame) -> None:
    errors = DisparityErrors(DisparityMaps(wall, SYSTEM))
    evidence = gather_evidence(errors)
    pairs = ((1, 2), (1, 3), (2, 3))
    assert evidence_scopes(SYSTEM) == (*SYSTEM.triples, *SYSTEM.triples[:3], *pairs, *pairs, *pairs)
    for (name, scope), share in zip(evidence_elements(SYSTEM), evidence, strict=True):
        if name == "holes":
            assert share == pytest.approx(np.isnan(errors.maps[scope].values).mean())
        elif name in ("brighter", "darker"):
            assert share == getattr(errors.maps.brightness(scope), name)
        else:
            assert share == getattr(errors[scope], name)


def test_light_that_a_matcher_copes_with_is_seen_by_its_brightness(wall: SensorFrame) -> None:
    for camera in (0, 1, 2):
        # Of little contrast, so that the dots do not hide a change of brightness.
        wall = wall.with_image(camera, wall.image(camera) // 6 + 60)
    lit = wall.image(1).copy()
    lit[:, 80:180] += 60
    clean = DisparityErrors(DisparityMaps(wall, SYSTEM))
    errors = DisparityErrors(DisparityMaps(wall.with_image(1, lit), SYSTEM))
    for triple in SYSTEM.triples:
        assert clean[triple].brightness < 0.02
        assert (errors[triple].brightness > 0.1) == (2 in triple), triple


def test_a_pair_with_one_grey_camera_is_matched_without_colours(wall: SensorFrame) -> None:
    tinted = wall
    for camera in (0, 2):
        tinted = tinted.with_image(camera, (wall.image(camera) * [0.9, 0.6, 0.3]).astype(np.uint8))
    grey = tinted.with_image(1, without_colours(tinted.image(0)))
    seen: list[SensorFrame] = []

    class Recorded(PairDepth):
        def estimator(self, calibration: Any, left: int, right: int) -> Any:
            found = super().estimator(calibration, left, right)

            class Recording:
                def disparity(self, frame: SensorFrame) -> Any:
                    seen.append(frame)
                    return found.disparity(frame)

            return Recording()

    maps = DisparityMaps(grey, SYSTEM, Recorded())
    maps.find([(1, 3), (2, 3)], threads=1)
    pair, mixed = seen
    assert pair.image(0) is grey.image(0)
    for camera in (0, 1):
        np.testing.assert_array_equal(mixed.image(camera), without_colours(grey.image(camera)))


def test_a_map_that_cannot_be(wall: SensorFrame) -> None:
    maps = DisparityMaps(wall, SYSTEM)
    for pair in ((0, 1), (3, 2), (2, 2), (0, 4), (-1, 2)):
        with pytest.raises(ConfigurationError, match="are those of"):
            maps[pair]
    blind = SensorFrame(wall.id, wall.calibration, {0: wall.image(0), 1: wall.image(1)})
    for pair in ((0, 3), (1, 3)):
        with pytest.raises(DataError):
            DisparityMaps(blind, SYSTEM)[pair]
    with pytest.raises(ConfigurationError, match="right to left"):
        DisparityMaps(wall, SensorSystem((LIDAR, 0, 1)))


def test_real_sensors_agree(shared) -> None:
    frame = KittiObject(shared / "kitti" / "object").frame("000107")
    error = DisparityErrors(DisparityMaps(frame, LIDAR_AND_TWO_CAMERAS))[0, 1, 2]
    # The thesis: clean frames are mostly below 20 %.
    assert error.error < 0.2
    assert error.hole_share < 0.25
    assert error.pixels > 15000


def test_narrow_pairs_search_less(wall: SensorFrame) -> None:
    rig = wall.calibration
    depth = PairDepth(nearest=4.0)
    assert depth.estimator(rig, 0, 2).disparities == 32
    assert depth.estimator(rig, 0, 1).disparities == 32
    assert depth.estimator(rig, 1, 2).disparities == 16
    assert depth.estimator(rig, 1, 2) is depth.estimator(rig, 1, 2)
    fixed = PairDepth({"name": "sgbm", "disparities": 64})
    assert fixed.estimator(rig, 1, 2).disparities == 64
    assert depth.settings == {"name": "sgbm", "nearest": 4.0}


def test_depth_that_cannot_be(wall: SensorFrame) -> None:
    rig = wall.calibration
    with pytest.raises(ConfigurationError, match="not right of"):
        PairDepth().estimator(rig, 2, 0)
    with pytest.raises(ConfigurationError, match="nearest takes a number"):
        PairDepth(nearest=0.0)
    with pytest.raises(ConfigurationError, match="name or a dictionary"):
        PairDepth(object())  # type: ignore[arg-type]
    with pytest.raises(ConfigurationError, match="no depth estimator"):
        PairDepth("crystal_ball").estimator(rig, 0, 1)
