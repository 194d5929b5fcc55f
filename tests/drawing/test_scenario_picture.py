"""Pictures: whole, not blank, and showing what they should."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import cv2
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from avsec_gym.attacks.object_injection import inject_ghosts
from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.scenario_picture import (
    BELIEVED,
    EGO,
    GOAL,
    REAL,
    TREE,
    draw_episode,
    draw_sheet,
    picture_array,
    save_picture,
)
from avsec_gym.geometry import ego_to_camera
from avsec_gym.metrics.safety import judge
from avsec_gym.pipeline import Episode, run_episode
from avsec_gym.planners.planner import MotionPrimitivePlanner
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.obstacles import Obstacles
from avsec_gym.scenario.planning_scenario import EgoState, Goal, PlanningScenario
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_sets import procedural_scenes
from avsec_gym.scenario.shapes import Disc, Group, Polygon, Rectangle

MARKER = "#c1272d"


def scene(poses: list[list[float]], moving: bool = False) -> Scene:
    location, rotation_y = ego_to_camera(np.array(poses, float).reshape(-1, 3), 1.65)
    count = len(rotation_y)
    boxes = Boxes3D(
        location=location,
        dimensions=np.tile([1.5, 1.6, 4.0], (count, 1)),
        rotation_y=rotation_y,
        score=np.ones(count),
        category=np.full(count, "Car"),
        moving=np.full(count, moving),
    )
    return Scene("one", boxes)


def where(picture: np.ndarray, colour: str) -> np.ndarray:
    """Rows and columns of the pixels of a colour, the words above and below left out."""
    away = np.abs(picture[80:540].astype(int) - np.array(to_rgb(colour)) * 255).max(axis=-1)
    return np.argwhere(away < 14)


def draw(shown: Episode) -> np.ndarray:
    return picture_array(draw_episode(shown))


def colliding() -> Episode:
    """A car in the way that is not detected."""
    return run_episode(scene([[13.0, -1.2, 0.0]]), Intention.STRAIGHT, Boxes3D.empty())


def test_a_collision_has_its_mark() -> None:
    shown = colliding()
    assert shown.record.collision
    assert len(where(draw(shown), MARKER)) > 40
    safe = run_episode(scene([[13.0, -1.2, 0.0]]), Intention.STRAIGHT)
    assert safe.record.safe
    assert len(where(draw(safe), MARKER)) == 0


def test_what_is_shown() -> None:
    one = scene([[13.0, -1.2, 0.0]])
    attacked = inject_ghosts(one.boxes, np.array([[24.0, 5.0, 0.3]]))
    clean, ghost = (
        draw(run_episode(one, Intention.STRAIGHT)),
        draw(run_episode(one, believed=attacked)),
    )
    assert len(where(clean, REAL)) > 500
    assert len(where(clean, EGO)) > 500
    assert len(where(ghost, BELIEVED)) > 50
    assert len(where(clean, BELIEVED)) == 0
    tree = MotionPrimitivePlanner(keep_tree=True)
    with_tree = draw(run_episode(one, Intention.STRAIGHT, planner=tree))
    assert (with_tree != clean).any(axis=-1).sum() > 500
    assert to_rgb(TREE)
    assert to_rgb(GOAL)


def test_left_is_up() -> None:
    """A car 4 m to the left stands in the upper half, one to the right in the lower."""
    rows = [
        where(draw(run_episode(scene([[25.0, y, 0.0]]), Intention.STRAIGHT)), REAL)[:, 0].mean()
        for y in (6.0, 0.0, -6.0)
    ]
    assert rows[0] < rows[1] - 50 < rows[2] - 100


def test_without_a_plan() -> None:
    wall = [[9.0, y, np.pi / 2] for y in np.arange(-40.0, 41.0, 3.9)]
    shown = run_episode(scene(wall), Intention.LEFT)
    assert not shown.record.planned
    assert len(np.unique(draw(shown))) > 50


@pytest.mark.parametrize("heading", [0.0, np.pi / 2, np.pi, -np.pi / 2, 0.7, 3.0, -2.4])
def test_a_turned_start_is_in_the_picture_as_a_whole(heading: float) -> None:
    cos, sin = np.cos(heading), np.sin(heading)
    start = EgoState(100.0, -50.0, 6.0, heading)
    goal = Rectangle(5.0, 3.5, 100.0 + 15 * cos, -50.0 + 15 * sin, heading)
    problem = PlanningScenario(
        "turned", start, (Goal((4, 30), (goal,), (heading - 0.5, heading + 0.5)),)
    )
    plan = MotionPrimitivePlanner().plan(problem)
    assert plan.trajectory is not None
    record = judge(plan, problem, problem.obstacles)
    figure = draw_episode(Episode(problem, plan, problem.obstacles, record))
    axes = figure.axes[0]
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    x, y = plan.trajectory[:, 0], plan.trajectory[:, 1]
    assert left < x.min() < x.max() < right
    assert low < y.min() < y.max() < high
    assert left < goal.x < right
    assert low < goal.y < high
    if abs(np.sin(2 * heading)) < 0.3:
        # What lies ahead is seen farther than what lies behind.
        assert left < 100.0 + 30 * cos < right
        assert low < -50.0 + 30 * sin < high


def obstacles(*rows: tuple[object, float, bool, int]) -> Obstacles:
    """Shapes at x, standing or not, from a first time step on."""
    count = len(rows)
    track = np.zeros((count, 31, 3))
    for i, (_, x, static, _) in enumerate(rows):
        track[i, :, 0], track[i, :, 1] = x, 6.0
        if not static:
            track[i, :, 0] += 0.3 * np.arange(31)
    return Obstacles(
        ids=np.arange(count),
        categories=np.full(count, "car"),
        shapes=tuple(row[0] for row in rows),  # type: ignore[misc]
        poses=track,
        speeds=np.zeros((count, 31)),
        steps=np.array([1 if row[2] else 31 for row in rows]),
        first_step=np.array([row[3] for row in rows]),
        static=np.array([row[2] for row in rows]),
    )


def test_shapes_of_every_kind_that_stand_move_and_appear_late() -> None:
    ell = Polygon(((0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)))
    group = Group((Disc(0.5, 0.0, -2.0), Rectangle(1.0, 1.0, 2.0, 1.0, 0.3)))
    around = obstacles(
        (Rectangle(4.0, 2.0), 5.0, True, 0),
        (Disc(1.0), 10.0, False, 0),
        (ell, 15.0, False, 7),
        (group, 20.0, True, 0),
    )
    goal = Goal((4, 30), (Disc(2.0, 15.0, 0.0),))
    problem = PlanningScenario("odd", EgoState(velocity=6.0), (goal,), obstacles=around)
    plan = MotionPrimitivePlanner(keep_tree=True).plan(problem)
    shown = Episode(problem, plan, around, judge(plan, problem, around))
    assert len(where(draw(shown), REAL)) > 1000


def test_a_png_is_written_whole(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "er" / "one.png"
    figure = draw_episode(colliding())
    save_picture(figure, path)
    assert [file.name for file in path.parent.iterdir()] == ["one.png"]
    picture = cv2.imread(str(path))
    assert picture is not None
    assert picture.shape == picture_array(figure).shape
    assert len(np.unique(picture.astype(int) @ (1, 256, 65536))) > 200


def test_a_png_that_fails_leaves_the_old_one(tmp_path: Path) -> None:
    path = tmp_path / "one.png"
    path.write_bytes(b"old")

    class Broken:
        def savefig(self, file: BytesIO, format: str) -> None:
            file.write(b"half")
            raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        save_picture(Broken(), path, overwrite=True)  # type: ignore[arg-type]
    assert path.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["one.png"]


def test_the_same_drive_is_the_same_picture() -> None:
    np.testing.assert_array_equal(draw(colliding()), draw(colliding()))


def test_an_arrow_stays_in_its_picture() -> None:
    """One car comes from behind the view: nothing is drawn outside of the axes."""
    figures = [
        draw_episode(run_episode(scene([[x, 8.0, 0.0]], moving=True), Intention.STRAIGHT))
        for x in (-20.0, 200.0)
    ]
    with_arrow, without = (picture_array(figure)[:, :18] for figure in figures)
    np.testing.assert_array_equal(with_arrow, without)


def test_a_sheet_of_several() -> None:
    episodes = [run_episode(scene, Intention.LEFT) for scene in procedural_scenes(3).scenes]
    figure = draw_sheet([*episodes, colliding()])
    assert len(figure.axes) == 4
    titles = [axes.get_title("right") for axes in figure.axes]
    assert titles[-1] == "COLLISION"
    assert len(np.unique(picture_array(figure))) > 50
