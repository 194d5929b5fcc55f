"""The frozen drives: the same in every release that has this version, and drives that matter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.benchmark.loop_scenes import LAYOUT, ROAD, digest_of_drives, frozen_drives
from avsec_gym.closed_loop.drive_record import Outcome
from avsec_gym.drives.one_drive import DriveTask, drive
from avsec_gym.drives.setting import DriveSetting
from avsec_gym.errors import ConfigurationError


def test_this_release_makes_the_scenes_of_the_version() -> None:
    frozen_drives().check(quick=True)
    assert all(path.is_file() for path in frozen_drives().error_models.values())


@pytest.mark.slow
def test_it_makes_all_of_them() -> None:
    frozen_drives().check()


def test_a_quick_entry_has_the_first_layouts() -> None:
    frozen = frozen_drives()
    kinds = [id.partition("-")[0] for id in frozen.ids()]
    assert kinds == sorted(kinds)
    assert {*kinds} == {LAYOUT, ROAD}
    assert frozen.ids(quick=True) == frozen.ids()[: frozen.quick]
    assert all(id.startswith(LAYOUT) for id in frozen.ids(quick=True))


def test_other_scenes_are_refused() -> None:
    with pytest.raises(ConfigurationError, match="are not those of version 1"):
        replace(frozen_drives(), seed=5).check(quick=True)


def test_every_drive_has_a_seed_of_its_own() -> None:
    frozen = frozen_drives()
    drives = [(id, way) for id, ways in frozen.ways.items() for way in ways]
    assert [frozen.number(*each) for each in drives] == [*range(len(drives))]


def test_drives_are_contested_in_closed_loop() -> None:
    frozen = frozen_drives()
    id = frozen.ids()[0]
    ends = {}
    for name in ("blind", "truth"):
        car = DriveSetting(name, {"perception": name}).environment(frozen.scenes)
        ends[name] = [drive(car, DriveTask(name, id, str(w), 0)).row for w in frozen.ways[id]]
    assert all(row["at_fault"] or row["outcome"] == Outcome.OFF_ROAD for row in ends["blind"])
    assert all(row["outcome"] == Outcome.GOAL for row in ends["truth"])


def test_the_digest_knows_millimetres_and_no_rounding_errors() -> None:
    scene = frozen_drives().scenes.scene(frozen_drives().ids()[0])
    tracks = scene.tracks
    exact = replace(tracks, poses=np.round(tracks.poses, 3))

    def moved(by: float) -> str:
        poses = exact.poses + np.array([by, 0.0, 0.0])
        return digest_of_drives([replace(scene, tracks=replace(exact, poses=poses))])

    assert moved(0.0) == moved(1e-9) != moved(0.002)
    assert digest_of_drives([scene]) != digest_of_drives([scene, scene])
    faster = replace(scene, start=replace(scene.start, velocity=scene.start.velocity + 2.0))
    assert digest_of_drives([faster]) != digest_of_drives([scene])
