"""Ghosts of stored detections, placed by what the scenes' images show."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.ghost_shares import ghost_rows
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.scenes import road_view_of, roadside_of
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.map_files import write_disparity, write_mask
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.frame_scenes import FrameScenes, frame_scenes
from avsec_gym.world.section import Surface

CALIBRATION = kitti_rig().calibration
HALF_WIDTH = 8.0
CLEAN, STRONG = Condition("dsgn"), Condition("dsgn", "thesis_pgd-1", 4.0)


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two frames of a wide road on a plane with a verge, of which the second has no maps."""
    root = tmp_path_factory.mktemp("frames")
    image = np.full((375, 1242, 3), 90, np.uint8)
    for number in range(2):
        frame = SensorFrame(f"{number:06d}", CALIBRATION, {2: image, 3: image})
        write_object_frame(root / "training", frame, Boxes3D.empty())
    p = CALIBRATION.projection()
    v, u = np.indices((375, 1242), dtype=float)
    ground = v > p[1, 2] + 5
    depth = np.where(ground, p[1, 1] * 1.65 / np.where(ground, v - p[1, 2], 1), 1e6)
    x = (u - p[0, 2]) * depth / p[0, 0]
    surface = np.where(np.abs(x) < HALF_WIDTH, Surface.ROAD, Surface.VERGE)
    disparity = CALIBRATION.focal_length() * CALIBRATION.baseline() / depth
    for name in ("surface_2", "disparity_2"):
        (root / "training" / name).mkdir()
    maps = root / "training" / "surface_2" / "000000.png"
    write_mask(maps, np.where(ground, surface, Surface.SKY).astype(np.uint8))
    write_disparity(maps.parents[1] / "disparity_2" / maps.name, np.where(ground, disparity, 0.01))
    return root


@pytest.fixture(scope="module")
def scenes(frames: Path) -> FrameScenes:
    return frame_scenes(frames)


def test_the_left_view_is_that_of_the_pair(scenes: FrameScenes) -> None:
    for scene in scenes.scenes.labelled:
        alone, pair = road_view_of(scenes, scene), roadside_of(scenes, scene).left
        np.testing.assert_array_equal(alone.road, pair.road)
        np.testing.assert_array_equal(alone.side, pair.side)
        shown = alone.road | alone.side
        np.testing.assert_array_equal(alone.disparity[shown], pair.disparity[shown])


def test_ghosts_are_placed_by_the_image(made: ModuleType, scenes: FrameScenes) -> None:
    """Ahead; on the road where no car drives; beside it; too unsure."""
    results, names = made.MadeResults(), made.names(2)
    ghosts = made.boxes(
        made.car(z=25.0, score=0.9),
        made.car(x=-7.0, z=24.0, score=0.9),
        made.car(x=10.0, z=20.0, score=0.9),
        made.car(x=-12.0, z=20.0, score=0.2),
    )
    for condition in (CLEAN, STRONG, Condition("dsgn", "thesis_pgd-1", 1.0)):
        results.add(condition, names, extra=None if condition == CLEAN else ghosts)
    results.add(Condition("dsgn", "patch-specific"), names)
    seen: list[tuple[int, int]] = []
    rows = ghost_rows(
        made.outcomes(results, names), scenes, 0.3, lambda done, total: seen.append((done, total))
    )
    assert [(row.condition.attack, row.condition.strength) for row in rows] == [
        ("unattacked", 0),
        ("thesis_pgd-1", 4),
    ]
    assert seen == [(1, 2), (2, 2)]
    clean, strong = rows
    assert (clean.summary.ghosts, clean.summary.share_on_road.value) == (0, None)
    # Without maps the road is taken to end 4 m aside.
    assert (strong.summary.road, strong.summary.side, strong.summary.unknown) == (3, 3, 0)
    assert strong.summary.share_on_road.value == pytest.approx(0.5)
    assert strong.summary.in_lanes == 2
    assert strong.positions["road"] == [[0.0, 25.0], [-7.0, 24.0], [0.0, 25.0]]
    assert 0 < strong.summary.chance.value < 1
