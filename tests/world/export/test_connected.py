"""Connected vehicles: one instant, several views, poses that bring them together, one truth."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.geometry import Floats, transform_points
from avsec_gym.kitti import KittiObject, read_labels
from avsec_gym.rig import SensorRig
from avsec_gym.validation.connected.recordings import recorded_instants
from avsec_gym.validation.connected.sources import connected_source
from avsec_gym.world.capture import render
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.export import (
    ConnectedWorld,
    Connection,
    Sensors,
    Sweep,
    WorldObject,
    make_data_set,
    suite_recipe,
)
from avsec_gym.world.export.connected_world import neighbours_of, read_pose
from avsec_gym.world.export.instants import read_instant

from .conftest import contents

NOISY = Connection(clocks_apart=0.1, position_noise=0.5, heading_noise=0.5)


def pose(folder: Path, id: str = "000000") -> Floats:
    return np.loadtxt(folder / f"pose/{id}.txt").reshape(3, 4)


@pytest.fixture(scope="module")
def connected(tmp_path_factory: pytest.TempPathFactory, rig: SensorRig) -> Path:
    root = tmp_path_factory.mktemp("connected")
    sensors = Sensors((2,), rig=rig, sweep=Sweep.INSTANT)
    make_data_set(suite_recipe("connected", 1, 1, sensors=sensors, vehicles=2), root, workers=1)
    return root


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory, rig: SensorRig) -> Path:
    """A drive of two instants and a single one, with clocks apart and noisy poses."""
    root = tmp_path_factory.mktemp("connected_drive")
    recipe = suite_recipe(
        "connected", 3, 2, sensors=Sensors((2,), rig=rig), drive_frames=2, connection=NOISY
    )
    make_data_set(recipe, root, workers=1)
    return root


@pytest.fixture(scope="module")
def watched(tmp_path_factory: pytest.TempPathFactory, rig: SensorRig) -> Path:
    """The instant of `connected`, with a LiDAR beside the road."""
    root = tmp_path_factory.mktemp("watched")
    sensors = Sensors((2,), rig=rig, sweep=Sweep.INSTANT)
    recipe = suite_recipe("connected", 1, 1, sensors=sensors, vehicles=2, roadside=True)
    make_data_set(recipe, root, workers=1)
    return root


def in_box(points: Floats, box: WorldObject, place: Floats, margin: float) -> int:
    """How many points of the world lie in a box at a pose x, y, heading."""
    away = points - [*place[:2], box.location[2]]
    cos, sin = np.cos(place[2]), np.sin(place[2])
    along, across = away[:, 0] * cos + away[:, 1] * sin, away[:, 1] * cos - away[:, 0] * sin
    height, width, length = box.dimensions
    inside = (np.abs(along) < 0.5 * length + margin) & (np.abs(across) < 0.5 * width + margin)
    return int((inside & (away[:, 2] > 0.12) & (away[:, 2] < height + margin)).sum())


def test_labels_of_both_lie_where_the_actors_are(connected: Path, rig: SensorRig) -> None:
    actors = drive_scenes(1, 0, 1, 2)[0].instant.actors
    checked = 0
    for vehicle in range(2):
        training = connected / f"vehicle_{vehicle}/training"
        data = KittiObject(connected / f"vehicle_{vehicle}")
        boxes = read_labels(training / "label_2/000000.txt")
        scene = json.loads((training / "scene/000000.json").read_text())
        velodyne = transform_points(data.calibration("000000").camera_to_velodyne, boxes.location)
        places = transform_points(pose(training), velodyne)
        for place, each in zip(places, scene["objects"], strict=True):
            index = int(np.flatnonzero(actors.id == each["actor"])[0])
            assert place == pytest.approx([*actors.pose[index, :2], actors.z[index]], abs=0.01)
            checked += 1
    assert checked > 0


def test_a_lidar_beside_the_road_changes_nothing_else(connected: Path, watched: Path) -> None:
    without, within = contents(connected), contents(watched)
    more = {name for name in within if name not in without}
    assert more == {
        f"vehicle_2/training/{kind}/000000.{suffix}"
        for kind, suffix in (
            ("velodyne", "bin"),
            ("calib", "txt"),
            ("pose", "txt"),
            ("measured_pose", "txt"),
        )
    }
    changed = {name for name in without if without[name] != within[name]}
    assert changed == {"manifest.json", "objects/000000.json", "meetings.json"}


def test_a_lidar_beside_the_road_is_one_more_witness(watched: Path) -> None:
    [instant] = recorded_instants(ConnectedWorld(watched))
    assert [scan.roadside for scan in instant.scans] == [False, False, True]
    pole, truth = instant.scans[2], instant.truth
    assert truth is not None
    assert truth.vehicles[2].is_roadside
    # It stands upright, 5 m above the ground, and off the carriageway; it knows where it is.
    world = drive_scenes(1, 0, 1, 2).world
    x, y, z = pole.pose[:3, 3]
    assert z - world.site.ground.height(x, y) == pytest.approx(5.0)
    np.testing.assert_array_equal(pole.pose[2, :3], [0, 0, 1])
    np.testing.assert_array_equal(pole.pose, instant.true_pose(2))
    _, left = world.site.course.coordinates(np.array([x]), np.array([y]))
    low, high = world.site.section.carriageway
    assert min(abs(left[0] - low), abs(left[0] - high)) == pytest.approx(0.8, abs=0.05)
    assert not low < left[0] < high
    # Its points lie on the same ground and the same objects, the sensor vehicles among them.
    places = pole.in_world()
    above = places[:, 2] - world.site.ground.height(places[:, 0], places[:, 1])
    assert (np.abs(above) < 0.25).mean() > 0.2
    assert (above < -0.5).mean() < 0.02
    assert max(each.points[2] for each in truth.objects[:2]) > 20
    for each in truth.objects:
        if each.points[2] > 200:
            inside = in_box(places, each, each.pose_after(0.0), 0.08)
            assert 0.7 * each.points[2] < inside <= 1.1 * each.points[2] + 5


def test_a_vehicle_knows_what_the_others_share(watched: Path, tmp_path: Path) -> None:
    views = ConnectedWorld(watched).views("000000")
    deliver = neighbours_of(KittiObject(watched / "vehicle_1"), "000000")
    assert deliver is not None
    shared = deliver()
    np.testing.assert_array_equal(shared.own.pose, views[1].measured_pose)
    assert [other.place.roadside for other in shared.others] == [False, True]
    for other, number in zip(shared.others, (0, 2), strict=True):
        assert callable(other.points)
        np.testing.assert_array_equal(other.points(), views[number].frame.points)
        np.testing.assert_array_equal(other.place.pose, views[number].measured_pose)
        assert other.place.period == 0.0
    # Other data, and instants that are not there, have no neighbours.
    shutil.copytree(watched / "vehicle_1", tmp_path / "vehicle_1")
    assert neighbours_of(KittiObject(tmp_path / "vehicle_1"), "000000") is None
    assert neighbours_of(KittiObject(watched / "vehicle_1"), "000007") is None


def test_a_lidar_beside_the_road_needs_scans() -> None:
    with pytest.raises(ConfigurationError, match="needs LiDARs"):
        suite_recipe("connected", 1, sensors=Sensors(lidar=False), roadside=True)


def test_scans_meet_on_the_ground(connected: Path) -> None:
    ground = drive_scenes(1, 0, 1, 2).world.site.ground
    for vehicle in range(2):
        root = connected / f"vehicle_{vehicle}"
        points = KittiObject(root).frame("000000").points[:, :3]
        world = transform_points(pose(root / "training"), points)
        above = world[:, 2] - ground.height(world[:, 0], world[:, 1])
        assert (np.abs(above) < 0.25).mean() > 0.2
        assert (above < -0.5).mean() < 0.02


def test_point_counts_are_those_of_the_scans(connected: Path, rig: SensorRig) -> None:
    """The renderer's own counts exactly; points in the world boxes but for wheels and edges."""
    world = ConnectedWorld(connected)
    instant = world.instant("000000")
    posed = drive_scenes(1, 0, 1, 2, rig)[0]
    assert len(instant.objects) > 5
    compared = 0
    for vehicle, view in enumerate(world.views("000000")):
        scan = render(posed, ego=vehicle, cameras=()).scan
        assert scan is not None
        np.testing.assert_array_equal(scan.points, view.frame.points)
        index = {int(id): i for i, id in enumerate(posed.instant.actors.id)}
        points = transform_points(view.pose, view.frame.points[:, :3])
        for each in instant.objects:
            exact = int((scan.object_id == index[each.actor]).sum())
            assert each.points[vehicle] == exact
            own = in_box(points, each, each.pose_after(0.0), 0.08)
            if exact > 200:
                assert 0.7 * exact < own <= 1.1 * exact + 5
                compared += 1
    assert compared >= 3
    assert instant.vehicles[0].actor == instant.objects[0].actor
    assert instant.objects[0].points[0] == 0, "a vehicle does not see itself"


@pytest.mark.slow
def test_world_boxes_hold_the_points_of_every_vehicle_at_its_own_time(drive: Path) -> None:
    """Through the true poses, with clocks apart and everything moving."""
    world = ConnectedWorld(drive)
    assert world.drives() == {0: ["000000", "000001"], 1: ["000002"]}
    share = []
    for id in world.ids():
        instant = world.instant(id)
        times = [vehicle.time for vehicle in instant.vehicles]
        assert 0.0 < np.ptp(times) <= 0.1
        for vehicle, view in enumerate(world.views(id)):
            assert view.time == times[vehicle]
            points = transform_points(view.pose, view.frame.points[:, :3])
            for each in instant.objects:
                if each.points[vehicle] > 100 and each.category == "Car":
                    # The scan rolls: margins are the way during half a turn.
                    margin = 0.1 + 0.05 * (abs(each.speed) + abs(instant.vehicles[vehicle].speed))
                    held = in_box(points, each, each.pose_after(view.time), margin)
                    share.append(held / each.points[vehicle])
    assert len(share) > 5
    assert np.median(share) > 0.8
    # One drive has one set of clocks, another has others.
    first, second, third = (world.instant(id) for id in world.ids())
    assert [v.time for v in first.vehicles] == [v.time for v in second.vehicles]
    assert [v.time for v in first.vehicles] != [v.time for v in third.vehicles]
    # And the first's world goes on in the second.
    later = {each.actor: each for each in second.objects}
    for each in first.objects:
        if each.actor in later:
            there = later[each.actor]
            assert each.pose_after(0.1)[:2] == pytest.approx(there.location[:2], abs=0.06)


def test_vehicles_stand_at_their_true_poses_and_near_their_measured_ones(drive: Path) -> None:
    world = ConnectedWorld(drive)
    rig_height = 1.73
    errors = []
    for id in world.ids():
        instant = world.instant(id)
        own = {each.actor: each for each in instant.objects}
        for vehicle, view in zip(instant.vehicles, world.views(id), strict=True):
            place = own[vehicle.actor].pose_after(vehicle.time)
            velodyne = view.pose[:3, 3]
            assert np.hypot(*(velodyne[:2] - place[:2])) < 0.4  # it stands 0.27 m behind
            above = velodyne[2] - own[vehicle.actor].location[2]
            assert above == pytest.approx(rig_height, abs=0.15)
            errors.append(view.measured_pose[:3, 3] - view.pose[:3, 3])
    assert 0.1 < np.abs(np.array(errors)[:, :2]).max() < 2.0
    np.testing.assert_allclose(np.array(errors)[:, 2], 0.0, atol=1e-8)


def test_the_meetings_are_counted(drive: Path) -> None:
    facts = json.loads((drive / "meetings.json").read_text())
    world = ConnectedWorld(drive)
    seen = [len(o.seen_by) for id in world.ids() for o in world.instant(id).objects]
    assert facts["instants"] == 3
    assert facts["objects"] == sum(count > 0 for count in seen)
    assert facts["seen_by"] == [seen.count(number) for number in (1, 2, 3)]
    assert facts["shared"] == pytest.approx(
        sum(count > 1 for count in seen) / facts["objects"], abs=1e-4
    )


@pytest.mark.slow
def test_two_workers_write_the_same(drive: Path, tmp_path: Path, rig: SensorRig) -> None:
    recipe = suite_recipe(
        "connected", 3, 2, sensors=Sensors((2,), rig=rig), drive_frames=2, connection=NOISY
    )
    make_data_set(recipe, tmp_path, workers=2)
    assert contents(tmp_path) == contents(drive)


def test_the_scan_rolls_unless_asked_otherwise(drive: Path, connected: Path) -> None:
    for root, sweep in ((drive, "rolling"), (connected, "instant")):
        scene = json.loads((root / "vehicle_0/training/scene/000000.json").read_text())
        assert scene["sweep"] == sweep
        assert json.loads((root / "manifest.json").read_text())["settings"]["sweep"] == sweep


def test_a_broken_truth_is_refused(drive: Path, tmp_path: Path) -> None:
    (tmp_path / "vehicle_0/training/label_2").mkdir(parents=True)
    (tmp_path / "objects").mkdir()
    facts = json.loads((drive / "objects/000000.json").read_text())
    facts["objects"][0]["points"] = [1, 2]
    (tmp_path / "objects/000000.json").write_text(json.dumps(facts))
    with pytest.raises(DataError, match="number of points for each vehicle"):
        ConnectedWorld(tmp_path).instant("000000")
    del facts["objects"][0]["heading"]
    (tmp_path / "objects/000000.json").write_text(json.dumps(facts))
    with pytest.raises(DataError, match="heading"):
        ConnectedWorld(tmp_path).instant("000000")
    with pytest.raises(DataError, match="no connected vehicles"):
        ConnectedWorld(tmp_path / "objects")


def test_a_data_set_that_lacks_something_is_refused(drive: Path, tmp_path: Path) -> None:
    whole = Path(shutil.copytree(drive, tmp_path / "whole"))
    source = connected_source(whole)
    assert len(source.names) > 1
    truth = (whole / "objects" / f"{source.names[1]}.json").read_text()
    (whole / "objects" / f"{source.names[1]}.json").unlink()
    with pytest.raises(DataError, match=rf"{source.names[1]}\.json: .*1 of {len(source.names)}"):
        connected_source(whole)
    (whole / "objects" / f"{source.names[1]}.json").write_text(truth)
    manifest = (whole / "manifest.json").read_text()
    (whole / "manifest.json").write_text(manifest.replace('"complete": true', '"complete": false'))
    with pytest.raises(DataError, match="not complete"):
        connected_source(whole)
    (whole / "manifest.json").unlink()
    with pytest.raises(DataError, match=r"manifest\.json: The manifest is missing"):
        connected_source(whole)
    with pytest.raises(DataError, match=r"manifest\.json"):
        next(recorded_instants(ConnectedWorld(whole)))


@pytest.mark.parametrize("wrong", [1e300, -1e300, 2**62, -(2**62), None, "1", True, [], {}])
def test_no_number_of_an_instant_can_be_anything(
    drive: Path, tmp_path: Path, wrong: object
) -> None:
    path = tmp_path / "000000.json"
    sound = json.loads((drive / "objects/000000.json").read_text())
    first = [sound, sound["vehicles"][0], sound["objects"][0]]
    first += [first[2][name] for name in ("location", "dimensions", "points")]
    tried = 0
    for owner in first:
        for key in range(len(owner)) if isinstance(owner, list) else list(owner):
            right = owner[key]
            if isinstance(right, bool | str | list):
                continue
            owner[key] = wrong
            path.write_text(json.dumps(sound))
            with pytest.raises(DataError, match=r"000000\.json"):
                read_instant(path)
            owner[key] = right
            tried += 1
    assert tried == 2 + 4 + 4 + 3 + 3 + len(sound["vehicles"])


@pytest.mark.parametrize("wrong", ["1e308", "-9.22e18", "4e7", "nan", "a"])
def test_no_number_of_a_pose_can_be_anything(drive: Path, tmp_path: Path, wrong: str) -> None:
    sound = (drive / "vehicle_0/training/pose/000000.txt").read_text().split()
    path = tmp_path / "pose.txt"
    path.write_text(" ".join(sound))
    assert read_pose(path).shape == (4, 4)
    for place in range(12):
        path.write_text(" ".join([*sound[:place], wrong, *sound[place + 1 :]]))
        with pytest.raises(DataError, match=r"pose\.txt: A pose"):
            read_pose(path)
    # A mirror keeps lengths, and is no rotation.
    path.write_text("1 0 0 5 0 1 0 5 0 0 -1 5")
    with pytest.raises(DataError, match="is a rotation"):
        read_pose(path)


@pytest.mark.parametrize(
    "wrong",
    [{"spacing": (60.0, 15.0)}, {"clocks_apart": 0.2}, {"position_noise": -0.1},
     {"heading_noise": float("nan")}],
)  # fmt: skip
def test_connections_that_cannot_be_are_refused(wrong: dict) -> None:
    with pytest.raises(ConfigurationError, match="got"):
        Connection(**wrong)
