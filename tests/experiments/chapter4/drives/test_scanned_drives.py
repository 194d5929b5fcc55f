"""What is out of a LiDAR's reach is left out of a drive, and no scan changes for it."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.experiments.chapter4.drives.scanned_drives import actors_near, with_actors
from avsec_gym.experiments.chapter4.procedural_instants import scanned_instant
from avsec_gym.world.assets import Assets
from avsec_gym.world.drives import drive_scenes


def test_actors_near_are_those_of_some_instant() -> None:
    scenes = drive_scenes(9300, 1, 3, 2, assets=Assets.TRAIN)
    near = actors_near(scenes)
    for index in range(len(scenes[0].instant.actors)):
        away = [
            float(np.hypot(*(pose[index] - pose[ego])[:2]))
            for scene in scenes
            for pose in [scene.instant.actors.pose]
            for ego in scene.instant.egos
        ]
        assert (index in near) == (min(away) < 95.0)
    assert set(scenes[0].instant.egos) <= set(near.tolist())


@pytest.mark.slow
def test_no_scan_changes() -> None:
    """Drive 6 has twice as many actors as are in reach."""
    scenes = drive_scenes(9200, 6, 1, 2, assets=Assets.TRAIN)
    near = actors_near(scenes)
    assert len(near) < 0.8 * len(scenes[0].instant.actors)
    whole = scanned_instant(scenes[0], [0.0, 0.05], 0, 0, "whole")
    fewer = scanned_instant(with_actors(scenes[0], near), [0.0, 0.05], 0, 0, "fewer")
    for scan, other in zip(whole.scans, fewer.scans, strict=True):
        np.testing.assert_array_equal(scan.points, other.points)
