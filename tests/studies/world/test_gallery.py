"""Pictures of the gallery: drawn from what they show, at the right places."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from avsec_gym.drawing.connected_picture import VEHICLE_COLOURS
from avsec_gym.rig import kitti_rig, resized_rig
from avsec_gym.world.capture import pinhole, render, renderer_of
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.layouts import layout_by_id
from avsec_gym.world.posed_scenes import posed_scene_of_layout
from avsec_gym.world.rendering.lidar import Lidar
from studies.world.gallery import PICTURES, STREET, instance_picture, main
from studies.world.light_steps import met_by_rays
from studies.world.panels import STRIP, panel_sheet
from studies.world.seen_from_above import FromAbove, connected_picture, layout_picture


def test_each_object_has_one_colour() -> None:
    image = np.full((4, 6, 3), 100, np.uint8)
    numbers = np.zeros((4, 6), np.uint16)
    numbers[0, :2], numbers[3, 4:] = 1, 2
    picture = instance_picture(image, numbers)
    assert (picture[1, 1] == 40).all()
    one, two = picture[0, 0], picture[3, 5]
    assert (picture[numbers == 1] == one).all()
    assert (picture[numbers == 2] == two).all()
    assert (one != two).any()


def test_panels_are_reduced_and_lie_in_a_grid() -> None:
    bright = np.full((60, 200, 3), 250, np.uint8)
    sheet = panel_sheet({"a": bright, "b": 0 * bright, "c": bright}, 2, 200)
    assert sheet.shape == (2 * (30 + STRIP) + 6, 206, 3)
    assert sheet[STRIP + 15, 90].mean() == 250
    assert sheet[STRIP + 15, 196].mean() == 0
    # Dark letters on a white strip above each.
    assert sheet[:STRIP, 106:150].min() < 100
    assert sheet[:STRIP, 150:].min() == 255


def test_places_ahead_are_right_and_places_to_the_left_above() -> None:
    canvas = FromAbove((100, 50), (-2.0, 5.0), 5.0)
    canvas.dots(np.array([[8.1, 3.1], [500.0, 0.0]]), np.array([[9, 8, 7], [1, 1, 1]]))
    rows, columns = np.nonzero((canvas.image == (9, 8, 7)).all(axis=2))
    assert (rows.tolist(), columns.tolist()) == ([9], [50])


def test_a_layout_shows_its_boxes_and_which_move() -> None:
    layout = layout_by_id(STREET)
    assert layout.boxes.moving is not None
    orange = (layout_picture(layout, (600, 200)) == (255, 170, 60)).all(axis=2)
    assert orange.any() == layout.boxes.moving.any()
    still = replace(layout, boxes=replace(layout.boxes, moving=np.zeros(len(layout.boxes), bool)))
    assert not (layout_picture(still, (600, 200)) == (255, 170, 60)).all(axis=2).any()


def test_the_steps_of_light_add_up_to_the_renderers() -> None:
    """On dull surfaces near by, colour times sun and surroundings is the light exposed."""
    posed = posed_scene_of_layout(layout_by_id(STREET), resized_rig(kitti_rig(), 160))
    renderer = renderer_of(posed)
    camera = pinhole(posed.rig, 2, posed.vehicle_to_world[0])
    hits, found, sunny, around = met_by_rays(renderer, posed, camera)
    light = (found.sunlight * sunny)[:, None] * posed.built.light.sun_colour + around
    view = renderer.view(camera).light.reshape(-1, 3)
    dull = (hits.face >= 0) & (hits.distance < 20.0) & (found.mirror == 0.0) & (found.glow == 0.0)
    dull &= (view < 1.0).all(axis=1) & ~renderer.scene.materials.leaves[
        renderer.scene.material[np.maximum(hits.face, 0)]
    ]
    share = view[dull] / np.maximum(found.albedo[dull] * light[dull], 1e-6)
    # One exposure fits nearly all; edges are averaged over several rays, shadows smoothed.
    exposure = np.median(share)
    assert dull.sum() > 1000
    assert np.mean(np.abs(share / exposure - 1.0) < 0.1) > 0.85


def test_connected_vehicles_stand_where_they_are_seen_from() -> None:
    rig = resized_rig(kitti_rig(), 64)
    posed = drive_scenes(seed=0, index=1, frames=1, egos=2, rig=rig)[0]
    lidar = Lidar(columns=400)
    scans = [render(posed, ego=ego, cameras=(), lidar=lidar).scan for ego in range(2)]
    assert all(scan is not None for scan in scans)
    picture = connected_picture(posed, [scan for scan in scans if scan is not None], 400, 200)
    centres = []
    for code in VEHICLE_COLOURS[:2]:
        colour = tuple(int(code[i : i + 2], 16) for i in (1, 3, 5))
        rows, columns = np.nonzero((picture == colour).all(axis=2))
        assert len(rows) > 30
        centres.append((np.median(rows), np.median(columns)))
    assert np.hypot(*np.subtract(*centres)) > 20.0


@pytest.mark.slow
def test_all_pictures_are_drawn(tmp_path: Path) -> None:
    assert main(["--out", str(tmp_path), "--width", "160"]) == 0
    assert {file.stem for file in tmp_path.iterdir()} == set(PICTURES)
    for file in tmp_path.iterdir():
        image = cv2.imread(str(file))
        assert image is not None
        assert image.std() > 10.0, file.name
