"""The scene that one can turn: numbers of the page against those of the episode and the labels."""

from __future__ import annotations

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.turnable_scene.page_part import style_and_script, turnable_part
from avsec_gym.drawing.turnable_scene.scene_data import (
    DrivenBelief,
    TurnableScene,
    turnable_scene,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.pipeline import run_episode
from avsec_gym.planners.vehicle import BMW_320I
from avsec_gym.rig import kitti_rig
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene

TRUTH = Boxes3D(
    [[3.0, 1.65, 12.0], [-1.0, 1.6, 25.0], [0.2, 1.6, 9.0], [0.0, 1.65, 500.0]],
    [[1.5, 1.7, 4.2], [1.8, 0.6, 0.8], [1.4, 1.6, 4.0], [1.5, 1.7, 4.2]],
    [-np.pi / 2, 0.0, -np.pi / 2, 0.0],
    np.ones(4),
    np.array(["Car", "Pedestrian", "Car", "Car"]),
    moving=np.array([True, False, False, False]),
)


def _driven(title: str, believed: Boxes3D) -> DrivenBelief:
    """An episode straight on by what is believed, through what is there."""
    episode = run_episode(Scene("000007", TRUTH), Intention.STRAIGHT, believed)
    return DrivenBelief(title, episode, believed)


@pytest.fixture(scope="module")
def scene() -> TurnableScene:
    points = np.array([[10.0, 2.0, -1.73, 0.3], [10.0, 90.0, 0.0, 0.3], [-10.0, -3.0, 1.0, 0.3]])
    images = {2: np.zeros((8, 8, 3), np.uint8), 3: np.zeros((8, 8, 3), np.uint8)}
    frame = SensorFrame("000007", kitti_rig().calibration, images, points.astype(np.float32))
    driven = [_driven("seeing", TRUTH), _driven("blind", Boxes3D.empty())]
    return turnable_scene("a <scene>", driven, TRUTH, frame=frame)


def test_boxes_stand_where_the_labels_have_them(scene: TurnableScene) -> None:
    real = scene.episodes[0].real
    # Neither the car half a kilometre ahead nor a pedestrian, whom no plan heeds, is shown.
    assert [each.size for each in real] == [(4.2, 1.7, 1.5), (4.0, 1.6, 1.4)]
    assert [each.bottom for each in real] == pytest.approx([0.0, 0.05])
    starts = np.array([each.poses[0] for each in real])
    assert starts == pytest.approx(np.array([[12.0, -3.0, 0.0], [9.0, -0.2, 0.0]]), abs=1e-6)


def test_what_moves_moves_and_what_stands_has_one_pose(scene: TurnableScene) -> None:
    episode = scene.episodes[1]
    moving, *standing = episode.real
    assert len(moving.poses) == len(episode.car) > 5
    gone = np.diff(moving.poses[:, 0])
    assert gone == pytest.approx(gone[0])
    assert gone[0] > 0.1
    assert all(len(each.poses) == 1 for each in standing)


def test_a_blind_car_stops_in_the_picture_where_it_collides(scene: TurnableScene) -> None:
    seeing, blind = scene.episodes
    assert blind.outcome == "collision"
    assert not blind.believed
    assert len(seeing.believed) == 3
    assert len(blind.car) < len(blind.planned)
    # It touches the parked car, whose rear is at 7 m.
    assert blind.car[-1, 0] + BMW_320I.length / 2 == pytest.approx(7.0, abs=1.0)
    assert seeing.outcome in ("safe", "unplanned")


def test_points_are_seen_from_the_ground_under_the_camera(scene: TurnableScene) -> None:
    data = scene.to_json()
    whole = np.frombuffer(base64.b64decode(data["points"]), "<i2").reshape(-1, 3) / 100
    # The velodyne stands 1.73 m above the ground, 0.27 m behind the camera, and they are not quite
    # parallel; what is far aside is left out.
    assert whole == pytest.approx(np.array([[9.73, 2.0, 0.0], [-10.27, -3.0, 2.73]]), abs=0.2)


def test_the_page_reads_what_was_written_and_nothing_ends_its_element_early(
    scene: TurnableScene,
) -> None:
    titled = replace(scene.episodes[0], title="</script><b>no plan</b>")
    part = turnable_part(replace(scene, episodes=(titled, scene.episodes[1])))
    (data,) = re.findall(r'<script type="application/json">(.*?)</script>', part, re.DOTALL)
    assert json.loads(data)["drives"][0]["title"] == titled.title
    assert json.loads(data)["drives"][1] == scene.episodes[1].to_json()
    assert "<b>" not in part
    assert "a &lt;scene&gt;" in part
    style, script = style_and_script()
    for name in set(re.findall(r'class="([a-z]+)"', part)) & {"turn", "steer", "time"}:
        assert f".{name}" in style + script


def test_without_a_scan_nothing_offers_it(scene: TurnableScene) -> None:
    assert 'value="points"' in turnable_part(scene)
    without = turnable_scene("a scene", [_driven("seeing", TRUTH)], TRUTH)
    assert 'value="points"' not in turnable_part(without)
