"""A textured box is painted into both images by another way than the module's own."""

from dataclasses import replace

import numpy as np
import pytest
import shapely

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.stereo_rcnn.alignment import MEASURED, Alignment
from avsec_gym.perception.detectors.stereo_rcnn.box_solver import (
    ObservedBoxes,
    SolvedBoxes,
    solve_boxes,
)
from avsec_gym.perception.detectors.stereo_rcnn.dense_alignment import align_depths
from avsec_gym.perception.detectors.stereo_rcnn.keypoints import stereo_truth
from avsec_gym.perception.detectors.stereo_rcnn.stereo_camera import StereoCamera

CAMERA = StereoCamera((720.0, 720.0), (620.0, 180.0), 0.54, (0.0, 0.0, 0.0), (375, 1242))
EXACT = Alignment(disparity_offset=0.0, parabola=True)


def scene(x, z, rotation_y, inset=0.0):
    """Images of a car 1.5 x 1.6 x 4 m, and its left 2D box; the surface lies `inset` inside."""
    half_length, half_width = 2.0 - inset, 0.8 - inset
    footprint = shapely.box(-half_length, -half_width, half_length, half_width)
    footprint = shapely.affinity.rotate(footprint, -rotation_y, (0, 0), use_radians=True)
    footprint = shapely.affinity.translate(footprint, x, z)
    columns = np.arange(1242)
    rays = [((u - 620) / 720, 1.0) for u in columns]
    depth = np.full(1242, 60.0)
    for u, (a, b) in enumerate(rays):
        hit = shapely.intersection(footprint, shapely.LineString([(0, 0), (100 * a, 100 * b)]))
        if not hit.is_empty:
            depth[u] = shapely.get_coordinates(hit)[:, 1].min()
    seen = np.flatnonzero(depth < 60)
    random = np.random.default_rng(0)
    waves, phases = random.uniform(0.15, 0.9, (3, 12)), random.uniform(0, 6, (3, 12))

    def texture(u):
        return 128 + 10 * np.sin(u[None, :, None] * waves[:, None] + phases[:, None]).sum(axis=2)

    right = np.broadcast_to(texture(columns.astype(float)).T, (375, 1242, 3))
    left = np.broadcast_to(texture(columns - 720 * 0.54 / depth).T, (375, 1242, 3))
    near = depth[seen].min()
    box = [seen[0], 180 + 720 * 0.15 / near, seen[-1], 180 + 720 * 1.65 / near]
    return left, right, np.array([box])


def observed(box, x, z, rotation_y):
    return ObservedBoxes(
        box,
        box,
        box[:, 0],
        np.zeros(1, int),
        box[:, [0, 2]],
        np.array([[1.5, 1.6, 4.0]]),
        np.array([rotation_y]),
    ), SolvedBoxes(np.array([[x, 1.65, z]]), np.array([rotation_y]), np.array([True]))


@pytest.mark.parametrize("z", [8.0, 15.0, 30.0])
@pytest.mark.parametrize(("x", "rotation_y"), [(0, -np.pi / 2), (3, 0.4), (-4, -1.2)])
def test_the_depth_of_a_textured_box_is_found(x, z, rotation_y):
    left, right, box = scene(x, z, rotation_y)
    seen, guess = observed(box, x, z, rotation_y)
    shift = 0.06 * z
    guess = replace(guess, location=guess.location * (z + shift) / z)
    depth, found, contrast = align_depths(left, right, seen, guess, CAMERA, EXACT)
    assert found.all()
    assert depth[0] == pytest.approx(z, abs=0.01 * z)
    # Texture that agrees at one depth only; two views of other things agree nowhere.
    other = np.random.default_rng(0).uniform(0, 255, right.shape).astype(np.float32)
    unlike = align_depths(left, other, seen, guess, CAMERA, EXACT)
    assert contrast[0] > 1.0 > 0.5 > unlike.contrast[0]


def test_steps_offset_and_parabola():
    left, right, box = scene(0, 15, -np.pi / 2)
    seen, guess = observed(box, 0, 15.62, -np.pi / 2)
    stepped = align_depths(left, right, seen, guess, CAMERA, replace(EXACT, parabola=False)).depth
    assert (stepped - 15.62) / 0.05 == pytest.approx(np.round((stepped - 15.62) / 0.05), abs=1e-6)
    smooth = align_depths(left, right, seen, guess, CAMERA, EXACT).depth
    assert abs(smooth[0] - 15) < abs(stepped[0] - 15) < 0.05
    offset = align_depths(left, right, seen, guess, CAMERA, Alignment()).depth
    assert offset == pytest.approx(720 * 0.54 / (720 * 0.54 / stepped + 0.5))


def test_what_mirrors_counts_little():
    left, right, box = scene(0, 15, -np.pi / 2)
    seen, guess = observed(box, 0, 15.6, -np.pi / 2)
    # A glint that both views see, as far away as what it mirrors.
    u1, v1, u2, v2 = box[0].astype(int)
    left, right = left.copy(), right.copy()
    for image, shift in ((left, 0), (right, 18)):
        image[v1:v2, (u1 + u2) // 2 - shift : (u1 + u2) // 2 + 22 - shift] = 255
    misled = align_depths(left, right, seen, guess, CAMERA, EXACT).depth
    robust = align_depths(left, right, seen, guess, CAMERA, replace(EXACT, most_difference=20.0))
    assert abs(robust.depth[0] - 15) < 0.1 < abs(misled[0] - 15)
    with pytest.raises(ConfigurationError, match="above 0"):
        Alignment(most_difference=0)


def test_a_body_inside_of_its_box_is_allowed_for():
    left, right, box = scene(2, 15, 0.5, inset=0.2)
    seen, guess = observed(box, 2, 15, 0.5)
    naive = align_depths(left, right, seen, guess, CAMERA, EXACT).depth
    inset = replace(EXACT, side_inset=0.2, front_inset=0.2, rear_inset=0.2)
    allowed = align_depths(left, right, seen, guess, CAMERA, inset).depth
    assert naive[0] > 15.15
    assert allowed[0] == pytest.approx(15, abs=0.05)


def test_only_what_is_between_the_borders_counts():
    left, right, box = scene(0, 12, -np.pi / 2)
    seen, guess = observed(box, 0, 12, -np.pi / 2)
    middle = int(box[0, [0, 2]].mean())
    spoilt = left.copy()
    spoilt[:, middle:] = np.roll(spoilt[:, middle:], 25, axis=1)
    half = replace(seen, borders=np.array([[box[0, 0], middle - 1]]))
    expected = align_depths(left, right, half, guess, CAMERA, EXACT).depth
    depth = align_depths(spoilt, right, half, guess, CAMERA, EXACT).depth
    assert depth == expected == pytest.approx(12, abs=0.05)


def test_without_pixels_the_solver_is_believed():
    left, right, box = scene(0, 12, -np.pi / 2)
    seen, guess = observed(box, 0, 12, -np.pi / 2)
    for case in (
        replace(seen, borders=box[:, [0, 0]]),
        replace(seen, left=box + np.array([0, 400, 0, 400])),
        replace(seen, left=box + np.array([3000, 0, 3000, 0]), borders=box[:, [0, 2]] + 3000),
    ):
        depth, found, contrast = align_depths(left, right, case, guess, CAMERA)
        assert (depth[0], found[0], contrast[0]) == (12, False, 0)
    assert len(align_depths(left, right, seen[:0], guess[:0], CAMERA)[0]) == 0


def test_a_search_needs_steps():
    with pytest.raises(ConfigurationError, match="steps"):
        Alignment(fine_steps=0)


@pytest.mark.slow
def test_rendered_cars_are_found_to_a_decimetre_or_two():
    from avsec_gym.world.capture import render
    from avsec_gym.world.layouts import generate_layout
    from avsec_gym.world.posed_scenes import posed_scene_of_layout

    # Sizes wrong by 4 % put the solver's depths wrong by as much.
    errors, before = [], []
    for seed in range(4):
        posed = posed_scene_of_layout(generate_layout(seed))
        capture = render(posed, cameras=(2, 3), lidar=None)
        images, boxes = capture.images, capture.labels.boxes
        projections = [posed.rig.calibration.projection(camera) for camera in (2, 3)]
        camera = StereoCamera.of_projections(*projections, images[2].shape[:2])
        truth = stereo_truth(boxes, camera)
        keypoints = np.isfinite(truth.keypoints)
        clear = keypoints.any(axis=1) & (truth.left[:, 0] > 25) & (truth.left[:, 2] < 1215)
        seen = ObservedBoxes(
            truth.left,
            truth.right,
            np.nan_to_num(np.nanmax(np.where(keypoints, truth.keypoints, -1), axis=1)),
            keypoints.argmax(axis=1),
            truth.borders,
            1.04 * truth.dimensions,
            truth.alpha,
        )[clear]
        solved = solve_boxes(seen, camera)
        depth = align_depths(images[2], images[3], seen, solved, camera, MEASURED).depth
        places = (boxes.location + camera.offset)[boxes.category == "Car"]
        for i, found in enumerate(depth):
            true = places[np.linalg.norm(places - solved.location[i], axis=1).argmin()]
            if true[2] < 30:
                errors.append(abs(found - true[2]))
                before.append(abs(solved.location[i, 2] - true[2]))
    assert len(errors) >= 4
    assert np.median(errors) < 0.2 < np.median(before)
