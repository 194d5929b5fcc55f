"""Procedural scenes on the roads that they lie on."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
import shapely

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.pipeline import run_episode
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import is_obstacle
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.own_road import own_road_of
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.road import Lanelet
from avsec_gym.scenario.roads import on_own_roads
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import procedural_scenes, scene_set
from avsec_gym.scenario.shapes import Rectangle
from avsec_gym.world.layouts import generate_layouts

COUNT = 40


@lru_cache(maxsize=1)
def scenes() -> SceneSet:
    return on_own_roads(procedural_scenes(COUNT))


def region(problem: PlanningScenario) -> Rectangle:
    assert problem.goals[0].region is not None
    (found,) = problem.goals[0].region
    assert isinstance(found, Rectangle)
    return found


def lane_below(scene: Scene, x: float, y: float) -> Lanelet:
    """The one lanelet that a point lies in, by shapely."""
    road = scene.problem(Intention.STRAIGHT).road
    (lane,) = [each for each in road.lanelets if each.polygon().contains(shapely.Point(x, y))]
    return lane


def test_the_traffic_drives_in_the_lanes_that_the_planner_sees() -> None:
    """Every moving vehicle stands on the road, and nearly all head along their lane."""
    seen, along = 0, 0
    for scene in scenes().labelled:
        road = scene.problem(Intention.STRAIGHT).road
        assert scene.boxes.moving is not None
        moving = scene.boxes[scene.boxes.moving & is_obstacle(scene.boxes)]
        for x, y, heading in moving.poses.tolist():
            assert road.area.contains(shapely.Point(x, y)), scene.id
            lane = lane_below(scene, x, y)
            middle = 0.5 * (np.array(lane.left) + np.array(lane.right))
            nearest = int(np.hypot(*(middle[:-1] - (x, y)).T).argmin())
            way = middle[nearest + 1] - middle[nearest]
            along += np.cos(np.arctan2(way[1], way[0]) - heading) > 0.9
            seen += 1
    assert seen > 20
    assert along / seen > 0.95


def test_thesis_lanes_do_not_follow_a_bend_and_own_ones_do() -> None:
    """In a bend the traffic ahead lies beside the thesis' own lane, and in the scene's own."""
    layouts = {layout.id: layout for layout in generate_layouts(COUNT)}
    bent = [s for s in scenes().labelled if abs(layouts[s.id].road.curvature) > 0.002]
    assert bent
    for scene in bent:
        road = layouts[scene.id].road
        x, y, _ = road.poses(np.array([60.0]), np.zeros(1), np.zeros(1))[0]
        assert abs(y) > 1.75
        start, there = lane_below(scene, 0.0, 0.0), lane_below(scene, x, y)
        assert start.id == there.id


def test_a_goal_lies_in_the_lane_that_the_intention_names_along_it() -> None:
    ways = set()
    for scene in scenes().labelled:
        start = lane_below(scene, 0.0, 0.0)
        beside = {
            Intention.LEFT: start.adjacent_left,
            Intention.STRAIGHT: (start.id, True),
            Intention.RIGHT: start.adjacent_right,
        }
        assert scene.own_road is not None
        for way, neighbour in beside.items():
            same_way = neighbour is not None and neighbour[1]
            assert (way in scene.intentions) == same_way
            if neighbour is None or not same_way:
                continue
            problem = scene.problem(way)
            goal = region(problem)
            lane = lane_below(scene, goal.x, goal.y)
            assert lane.id == neighbour[0]
            inside = lane.polygon().buffer(0.1).intersection(goal.polygon()).area
            assert inside == pytest.approx(goal.polygon().area, rel=0.02)
            low, high = problem.goals[0].heading or (0.0, 0.0)
            assert 0.5 * (low + high) == pytest.approx(goal.heading)
            assert np.hypot(goal.x, goal.y) == pytest.approx(15.0, abs=1.5)
            ways.add(way)
    assert {Intention.LEFT, Intention.STRAIGHT} <= ways


def test_plans_stay_on_the_road() -> None:
    planned = 0
    for scene in scenes().labelled:
        episode = run_episode(scene, believed=Boxes3D.empty())
        if episode.plan.trajectory is None:
            continue
        planned += 1
        places = shapely.points(episode.plan.trajectory[:, :2])
        assert episode.problem.road.area.contains(places).all()
    assert planned > 0.9 * COUNT


def test_lanes_lie_side_by_side() -> None:
    for layout in generate_layouts(COUNT):
        lanes = own_road_of(layout).lanes
        for right, left in pairwise(lanes):
            assert right.left <= left.right + 1e-9
        assert all(2.4 < lane.width < 7.0 for lane in lanes)


@pytest.mark.slow
@pytest.mark.parametrize("road_type", RoadType)
def test_the_lanes_are_those_that_the_world_renders(road_type: RoadType) -> None:
    from avsec_gym.world.layouts import generate_layout
    from avsec_gym.world.posed_scenes import posed_scene_of_layout

    layout = generate_layout(7, road_type)
    site, road = posed_scene_of_layout(layout).site, own_road_of(layout)
    assert [lane.direction for lane in site.section.lanes] == [x.direction for x in road.lanes]
    for rendered, lane in zip(site.section.lanes, road.lanes, strict=True):
        assert lane.right < rendered.left < lane.left
    along = np.linspace(0.0, 60.0, 13)
    np.testing.assert_allclose(
        road.course.poses(along, 0.0), site.course.poses(along, 0.0), atol=0.05
    )


def test_an_intention_without_a_lane_is_refused() -> None:
    street = next(s for s in scenes().labelled if s.intentions == (Intention.STRAIGHT,))
    assert not scenes().plays(street.id, Intention.LEFT)
    with pytest.raises(ConfigurationError, match=r"lies to the left.*intentions here: straight"):
        street.problem(Intention.LEFT)
    assert street.possible(tuple(Intention)) == (Intention.STRAIGHT,)


def test_scenes_of_labels_have_no_road_of_their_own() -> None:
    scene = Scene("000107", Boxes3D.empty())
    with pytest.raises(ConfigurationError, match=r"000107 of labels has no road of its own"):
        on_own_roads(SceneSet("labels", (scene,)))


def test_what_is_contested_is_found_out_on_the_own_road() -> None:
    placed = on_own_roads(scene_set("mixed_contested", count=12))
    assert placed.intentions is not None
    assert len(placed)
    for scene in placed.labelled:
        for way in placed.intentions[scene.id]:
            assert not run_episode(scene, way, Boxes3D.empty()).record.safe
