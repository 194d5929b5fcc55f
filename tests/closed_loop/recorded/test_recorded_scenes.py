from __future__ import annotations

from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401 - registers the environments.
from avsec_gym.closed_loop.loop_scenes import loop_scenes
from avsec_gym.closed_loop.recorded.recorded_scenes import recorded_windows
from avsec_gym.closed_loop.recorded.windows import Refusal
from avsec_gym.envs.planner_driver import PlannerDriver
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.calibration import write_calibration
from avsec_gym.kitti.oxts_poses import oxts_from_poses
from avsec_gym.kitti.raw_calibration import write_raw_calibration
from avsec_gym.kitti.tracking import write_tracking_labels
from avsec_gym.kitti.writing import write_drive_records
from avsec_gym.world.drives import DriveScenes, drive_scenes
from avsec_gym.world.export.tracks import Sighting, tracklets_of
from studies.driving_safety.procedural_labels import drive_labels

FRAMES = 91
NAME = "2026_01_01_drive_0001_sync"


@pytest.fixture(scope="module")
def scenes() -> DriveScenes:
    return drive_scenes(7, 3, FRAMES)


@pytest.fixture(scope="module")
def raw(scenes: DriveScenes, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A procedural drive in the raw layout: oxts and tracklets, no images."""
    root = tmp_path_factory.mktemp("raw")
    frames, _ = drive_labels(scenes, 0)
    sightings = {
        frame: [Sighting(int(id), 0, 0.0) for id in tracked.tracks]
        for frame, tracked in frames.items()
    }
    date = root / "2026_01_01"
    write_raw_calibration(date, scenes.rig.calibration, image_size=scenes.rig.size)
    imu = scenes.world.ego_poses[:, 0] @ scenes.rig.imu_pose
    write_drive_records(
        date / NAME,
        oxts=oxts_from_poses(imu),
        timestamps={},
        tracklets=tracklets_of(scenes, sightings),
    )
    return root


@pytest.fixture(scope="module")
def tracking(scenes: DriveScenes, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same drive as a tracking sequence without oxts."""
    root = tmp_path_factory.mktemp("tracking")
    write_tracking_labels(root / "training/label_02/0000.txt", drive_labels(scenes, 0)[0])
    return root


def test_a_raw_drive_is_where_the_procedural_one_was(scenes: DriveScenes, raw: Path) -> None:
    found = loop_scenes("kitti_raw", root=raw)
    assert found.ids == (f"{NAME}-000000", f"{NAME}-000010")
    scene = found.scene(f"{NAME}-000010")
    first = scenes.world.ego_poses[10, 0] @ scenes.rig.camera_pose(0)
    forward = first[:2, 2] / np.hypot(*first[:2, 2])
    apart = scenes.world.instants[50].actors.pose[:, :2] - first[:2, 3]
    actors = np.column_stack([apart @ forward, apart @ (-forward[1], forward[0])])
    present = [i for i in range(len(scene.tracks)) if scene.tracks.present(i, 4.0)]
    assert len(present) > 5
    for track in present:
        x, y, _, speed = scene.tracks.state(track, 4.0)
        away = np.hypot(*(actors - (x, y)).T).min()
        # Movers are smoothed, and drive on straight where no label is left.
        assert away < (0.5 if speed else 0.05)


def test_a_sequence_without_oxts_is_driven_in_by_its_standing_cars(tracking: Path) -> None:
    env = gym.make(
        "avsec/ClosedLoop-v0", scenarios={"source": "kitti_tracking", "root": str(tracking)}
    )
    driver = PlannerDriver(env)
    observation, info = env.reset(seed=0, options={"intention": "straight"})
    ended = False
    while not ended:
        action, _ = driver.predict(observation)
        observation, _, terminated, truncated, info = env.step(action)
        ended = terminated or truncated
    assert info["scenario"].startswith("0000-")
    assert info["outcome"] == "goal"


def test_oxts_of_a_sequence_are_used(scenes: DriveScenes, tracking: Path, tmp_path: Path) -> None:
    frames, truth = drive_labels(scenes, 0)
    write_tracking_labels(tmp_path / "training/label_02/0000.txt", frames)
    write_calibration(tmp_path / "training/calib/0000.txt", scenes.rig.calibration)
    rows = oxts_from_poses(scenes.world.ego_poses[:, 0] @ scenes.rig.imu_pose).rows
    text = "\n".join(
        " ".join([*map(repr, row[:25]), *(f"{flag:.0f}" for flag in row[25:])])
        for row in rows.tolist()
    )
    path = tmp_path / "training/oxts/0000.txt"
    path.parent.mkdir()
    path.write_text(text + "\n")
    [given] = recorded_windows("kitti_tracking", tmp_path)
    [estimated] = recorded_windows("kitti_tracking", tracking)
    assert given.known.estimate is None
    assert estimated.known.estimate is not None
    assert np.abs(given.known.poses[:, :2] - truth[:, :2]).max() < 0.02
    assert np.abs(estimated.known.poses[:, :2] - truth[:, :2]).max() < 0.7
    path.write_text(text.split("\n")[0] + "\n")
    with pytest.raises(DataError, match="1 measurements for 91"):
        recorded_windows("kitti_tracking", tmp_path / "training")


def test_what_is_missing_is_named(tmp_path: Path, raw: Path) -> None:
    with pytest.raises(ConfigurationError, match="needs the folder of its data"):
        loop_scenes("kitti_tracking")
    with pytest.raises(ConfigurationError, match="root and every are for"):
        loop_scenes("layouts", root=tmp_path)
    with pytest.raises(DataError, match="tracking layout"):
        loop_scenes("kitti_tracking", root=tmp_path)
    (tmp_path / "training/label_02").mkdir(parents=True)
    (tmp_path / "training/label_02/0000.txt").write_text("\n")
    with pytest.raises(DataError, match=Refusal.SHORT):
        loop_scenes("kitti_tracking", root=tmp_path)
    with pytest.raises(ConfigurationError, match="every"):
        gym.make(
            "avsec/ClosedLoop-v0", scenarios={"source": "kitti_raw", "root": str(raw), "every": 0}
        )


@pytest.mark.slow
def test_real_sequences_give_scenes(shared: Path) -> None:
    windows = {
        each.known.recording.id: each
        for each in recorded_windows("kitti_tracking", shared / "kitti/tracking")
    }
    assert len(windows) == 21
    assert sum(len(each.starts) for each in windows.values()) > 80
    # The traffic of a motorway all drives one way; nothing stands in view of 0012 and 0017.
    assert not any(windows[id].starts for id in ("0012", "0017", "0020"))
    [drive] = recorded_windows("kitti_raw", shared / "kitti/raw")
    assert len(drive.starts) == 3
