"""What is out of a LiDAR's reach is left out of a drive, and no scan changes for it."""

from __future__ import annotations

import numpy as np
import pytest

from avsec_gym.experiments.chapter4.drives.scanned_drives import within_reach
from avsec_gym.experiments.chapter4.procedural_instants import scanned_instant
from avsec_gym.world.assets import Assets
from avsec_gym.world.drives import drive_scenes


def test_those_within_reach_of_some_vehicle_stay() -> None:
    for posed in drive_scenes(9300, 1, 3, 2, assets=Assets.TRAIN):
        every, fewer = posed.instant, within_reach(posed).instant
        kept = set(fewer.actors.id.tolist())
        for index, actor in enumerate(every.actors.id.tolist()):
            away = [
                float(np.hypot(*(every.actors.pose[index] - every.actors.pose[ego])[:2]))
                for ego in every.egos
            ]
            assert (actor in kept) == (min(away) < 95.0)
        assert [fewer.actors.id[ego] for ego in fewer.egos] == [
            every.actors.id[ego] for ego in every.egos
        ]


@pytest.mark.slow
def test_no_scan_changes() -> None:
    """Drive 6 has many more actors than are in reach."""
    [posed] = drive_scenes(9200, 6, 1, 2, assets=Assets.TRAIN)
    near = within_reach(posed)
    assert len(near.instant.actors) < 0.9 * len(posed.instant.actors)
    whole = scanned_instant(posed, [0.0, 0.05], 0, 0, "whole")
    fewer = scanned_instant(near, [0.0, 0.05], 0, 0, "fewer")
    for scan, other in zip(whole.scans, fewer.scans, strict=True):
        np.testing.assert_array_equal(scan.points, other.points)
