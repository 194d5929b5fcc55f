"""OPV2V-style folders become instants in a right-handed world, in which all vehicles agree."""

from pathlib import Path

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.validation.connected.opv2v.scenario_folders import find_scenarios, opv2v_instants
from avsec_gym.validation.connected.sweep import TIP
from tests.validation.connected.opv2v.opv2v_sample import (
    SENSORS,
    faces_of_car,
    write_sample,
    write_yaml,
)


def test_all_vehicles_see_the_car_where_it_is(tmp_path: Path) -> None:
    write_sample(tmp_path)
    [scenario] = find_scenarios(tmp_path)
    first, second = opv2v_instants(scenario)
    assert first.id == "2021_08_22_21_41_24/00069"
    expected = faces_of_car() * [1, -1, 1]
    for scan in first.scans:
        assert np.linalg.det(scan.pose[:3, :3]) == pytest.approx(1.0)
        assert scan.in_world() == pytest.approx(expected, abs=1e-4)
        assert scan.points[:, 3] == pytest.approx(128 / 255)
    assert second.truth is not None
    assert second.truth.frame == 1


def test_a_negative_number_is_a_lidar_beside_the_road(tmp_path: Path) -> None:
    folder = write_sample(tmp_path)
    (folder / "650").rename(folder / "-1")
    [instant, *_] = opv2v_instants(find_scenarios(folder)[0])
    assert [scan.roadside for scan in instant.scans] == [True, False]
    assert instant.truth is not None
    assert [each.is_roadside for each in instant.truth.vehicles] == [True, False]
    assert [each.actor for each in instant.truth.vehicles] == [-1, 641]


def test_the_truth_is_the_listed_vehicle_once(tmp_path: Path) -> None:
    [instant, *_] = opv2v_instants(find_scenarios(write_sample(tmp_path))[0], "measured")
    assert instant.truth is not None
    [car] = instant.truth.objects
    assert car.actor == 1732
    # CARLA's yaw turns to the right, ours to the left.
    assert np.degrees(car.heading) == pytest.approx(-30.0)
    assert car.location == pytest.approx((20.0, -6.0, 0.1))
    assert car.dimensions == pytest.approx((1.4, 1.8, 4.4))
    assert car.speed == pytest.approx(5.0)
    assert car.moving
    assert car.points == (60, 60)
    assert [each.actor for each in instant.truth.vehicles] == [641, 650]
    assert instant.truth.vehicles[0].speed == pytest.approx(10.0)


def test_measured_poses_are_off_by_what_the_vehicle_misjudged(tmp_path: Path) -> None:
    [scenario] = find_scenarios(write_sample(tmp_path))
    true, measured = next(opv2v_instants(scenario)), next(opv2v_instants(scenario, "measured"))
    for one, other in zip(true.scans, measured.scans, strict=True):
        assert other.pose - one.pose == pytest.approx(
            np.array([[0, 0, 0, 1.0], [0] * 4, [0] * 4, [0] * 4]), abs=1e-9
        )


def test_rays_leave_the_tip_of_the_velodyne_frame(tmp_path: Path) -> None:
    instant = next(opv2v_instants(find_scenarios(write_sample(tmp_path))[0]))
    for scan, sensor in zip(instant.scans, SENSORS.values(), strict=True):
        tip = scan.pose @ [0, 0, TIP, 1]
        assert tip[:3] == pytest.approx(np.array(sensor[:3]) * [1, -1, 1])


def test_an_instant_that_a_vehicle_lacks_is_left_out(tmp_path: Path) -> None:
    scenario = write_sample(tmp_path)
    (scenario / "650" / "00069.pcd").unlink()
    [instant] = opv2v_instants(find_scenarios(scenario)[0])
    assert instant.id.endswith("00071")


def test_what_is_no_scenario_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no scenario"):
        find_scenarios(tmp_path)
    with pytest.raises(DataError, match="no scenario"):
        find_scenarios(tmp_path / "absent")
    (tmp_path / "one" / "641").mkdir(parents=True)
    with pytest.raises(DataError, match="1 vehicles with 0"):
        next(opv2v_instants(find_scenarios(tmp_path / "one")[0]))
    [scenario] = find_scenarios(write_sample(tmp_path / "sound"))
    with pytest.raises(ConfigurationError):
        next(opv2v_instants(scenario, "guessed"))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("text", "problem", "line"),
    [
        ("lidar_pose: [0, 0, 0, 0, 0]", "6 numbers", 1),
        ("a: 1\nlidar_pose: [0, 0, .nan, 0, 0, 0]", "no number", 2),
        ("lidar_pose: [0, 0, 1e9, 0, 0, 0]", "at most", 1),
        ("lidar_pose: [0, 0, 0, 0, 1e4, 0]", "two turns", 1),
        ("ego_speed: 3", "no lidar_pose", 1),
        ("- 1", "no mapping", 1),
        ("a: 1\na: 2", "twice", 2),
        ("a: [1", "no YAML", 1),
        (r'a: "\UFFFFFFFF"', "no YAML", None),
        (r'a: "\U00110000"', "no YAML", None),
        ("", "empty", None),
        ("[" * 5000, "deep", None),
    ],
)
def test_a_broken_yaml_is_refused_with_its_line(
    tmp_path: Path, text: str, problem: str, line: int | None
) -> None:
    scenario = write_sample(tmp_path)
    (scenario / "641" / "00069.yaml").write_text(text)
    with pytest.raises(DataError, match=problem) as caught:
        next(opv2v_instants(find_scenarios(scenario)[0]))
    assert "00069.yaml" in str(caught.value)
    assert caught.value.line == line


def test_a_tree_of_references_takes_no_memory(tmp_path: Path) -> None:
    scenario = write_sample(tmp_path)
    path = scenario / "641" / "00069.yaml"
    laughs = "a: &a [1, 2]\n" + "".join(
        f"{new}: &{new} [*{old}, *{old}]\n"
        for old, new in zip("abcdefghi", "bcdefghij", strict=True)
    )
    write_yaml(path, SENSORS["641"])
    path.write_text(laughs + path.read_text())
    assert next(opv2v_instants(find_scenarios(scenario)[0])).truth is not None
