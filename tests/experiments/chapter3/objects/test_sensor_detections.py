"""Baseline, impact and sensitivity on walls of dots, by detectors that know the truth."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from avsec_gym import registry
from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter3.objects.attack_sizes import (
    COVERED,
    RADII,
    WIDTHS,
    AttackSizes,
    size_cells,
    size_inputs,
)
from avsec_gym.experiments.chapter3.objects.bogus_obstacles import taken_for_an_obstacle
from avsec_gym.experiments.chapter3.objects.detector_weights import weights_of
from avsec_gym.experiments.chapter3.objects.frame_truth import truth_of
from avsec_gym.experiments.chapter3.objects.mismatch_counts import IOUS, mismatch_counts
from avsec_gym.experiments.chapter3.objects.score_thresholds import (
    USUAL,
    ScoreThreshold,
    score_thresholds,
)
from avsec_gym.experiments.chapter3.objects.sensor_detections import (
    DETECTIONS_FORMAT,
    PATCH,
    SensorDetections,
    detection_cells,
    detection_inputs,
    truth_setting,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import transform_points
from avsec_gym.kitti.labels import read_labels
from avsec_gym.kitti.raw import Drive, KittiRaw
from avsec_gym.kitti.tracklets import Tracklet, write_tracklets
from avsec_gym.perception.detectors.image_detector import image_boxes
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.runs.catalogue import experiment
from avsec_gym.runs.experiment import CellResult, Configuration, Measurement
from avsec_gym.sensor_system import KITTI_SYSTEM
from avsec_gym.validation.evidence.evidence import EVIDENCE_FORMAT

LABEL = "Car 0.00 0 -1.57 109.60 62.14 141.60 93.00 1.50 1.60 4.00 0.00 1.65 12.00 -1.57\n"
DONT_CARE = "DontCare -1 -1 -10 1 2 9 9 -1 -1 -1 -1000 -1000 -1000 -10\n"
CAMERAS = (1, 3, 2)
BRIGHT = 170
FROM_0_3 = {"lidar": ScoreThreshold(0.3), "camera": ScoreThreshold(0.3)}


def write_drive(walls: ModuleType, root: Path, frames: int, first: int = 0) -> Path:
    for number in range(frames):
        folder = walls.write_wall(root, 1, number, first + number)
        path = folder / "label_02" / "data" / f"{number:010d}.txt"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(LABEL + DONT_CARE)
    return root


def labels(frame: SensorFrame) -> Boxes3D:
    assert frame.origin is not None
    return read_labels(frame.origin / "label_02" / "data" / f"{frame.id}.txt")


class Radar:
    """Knows the labels, and sees a car wherever the drive's own scan has no points."""

    name = "radar"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        assert not frame.images, "a scan is looked at alone"
        return self.also_bogus(frame)

    def also_bogus(self, frame: SensorFrame) -> Boxes3D:
        assert frame.origin is not None
        clean = len(Drive(frame.origin).frame(int(frame.id)).points)
        places = transform_points(frame.calibration.velodyne_to_camera, frame.points[clean:, :3])
        if not len(places):
            return labels(frame)
        phantom = Boxes3D(
            [[places[:, 0].mean(), 1.65, places[:, 2].mean()]], [[1.5, 1.6, 2.6]], [0.0], [0.9],
            ["Car"],
        )  # fmt: skip
        unsure = replace(phantom, location=[[0.0, 1.65, 30.0]], score=[0.1])
        bare = {"box2d": None, "truncation": None, "occlusion": None, "alpha": None}
        return Boxes3D.concatenate([replace(labels(frame), **bare), phantom, unsure])


class Window:
    """Knows the label, and sees it where light has not made it bright."""

    name = "window"

    def detect(self, frame: SensorFrame, camera: int = 2) -> Boxes3D:
        u, v, u_end, v_end = (110, 62, 142, 93)
        # The car's rear stands 10 m ahead.
        shift = round(200 * frame.calibration.baseline(2, camera) / 10)
        image = frame.image(camera)[v:v_end, u - shift : u_end - shift]
        seen = [[float(u - shift), v, u_end - shift, v_end]] if image.mean() < BRIGHT else []
        return image_boxes(np.reshape(seen, (-1, 4)), np.ones(len(seen)), ["Car"] * len(seen))


class WholeRadar(Radar):
    """The same, of whole frames, with 2D boxes."""

    def detect(self, frame: SensorFrame) -> Boxes3D:
        boxes = self.also_bogus(frame)
        return replace(boxes, box2d=np.tile([110.0, 62, 142, 93], (len(boxes), 1)))


@pytest.fixture(autouse=True)
def detectors(monkeypatch: pytest.MonkeyPatch) -> None:
    for kind, name, factory in (
        (registry.Kind.DETECTOR, "radar", Radar),
        (registry.Kind.DETECTOR, "whole_radar", WholeRadar),
        (registry.Kind.IMAGE_DETECTOR, "window", Window),
    ):
        monkeypatch.setitem(registry._REGISTERED, (kind, name), factory)


@pytest.fixture(scope="module")
def configuration(
    tmp_path_factory: pytest.TempPathFactory, walls: ModuleType
) -> Iterable[Configuration]:
    root = tmp_path_factory.mktemp("drives")
    options = {
        "fit": str(write_drive(walls, root / "fit", 2, first=5000)),
        "lidar_detector": "radar",
        "image_detector": "window",
        "sensitivity_lidar": "whole_radar",
        "sensitivity_image": "window",
    }
    return Configuration(str(write_drive(walls, root / "judged", 3)), options=options)


def boxes_of(result: CellResult) -> dict[tuple[str, float], Boxes3D]:
    return {(row.setting, row.strength): row.boxes for row in result.detections}


def values_of(result: CellResult) -> dict[tuple[str, str, float], float]:
    return {(row.setting, row.name, row.strength): row.value for row in result.measurements}


class Kept:
    """What cells came to, as a run keeps it."""

    def __init__(self, *cells: CellResult) -> None:
        self._cells = cells

    def detections(self, setting: str, strength: float = 0.0) -> dict[str, Boxes3D]:
        rows = (row for cell in self._cells for row in cell.detections)
        return {row.scenario: row.boxes for row in rows if row.setting == setting}

    def measurements(self, **where: Any) -> list[Measurement]:
        rows = (row for cell in self._cells for row in cell.measurements)
        return [
            row
            for row in rows
            if all(getattr(row, column) == value for column, value in where.items())
        ]


def test_baseline_and_impact_share_their_cells(configuration: Configuration) -> None:
    cells = detection_cells(configuration)
    assert [cell.arguments["part"] for cell in cells] == ["fitted"] * 2 + ["judged"] * 3
    assert experiment("impact").cells(configuration) == cells
    assert experiment("object_level").cells(configuration) == cells
    assert len(size_cells(configuration)) == 5
    assert detection_inputs(configuration) == {}
    for name in ("object_level", "impact", "sensitivity"):
        assert experiment(name).name == name


def test_weights_are_inputs_of_a_run(configuration: Configuration) -> None:
    for inputs, options, named in (
        (detection_inputs, {"lidar_detector": "pixor", "pixor": ""}, "pixor"),
        (size_inputs, {"sensitivity_image": "yolo"}, "yolo"),
    ):
        asked = replace(configuration, options={**configuration.options, **options})
        files = inputs(asked)
        assert files[f"weights of {named}"] == shipped_weights(f"{named}_small")
        assert files[f"card of {named}"].suffix == ".json"
    assert weights_of("yolo", {"yolo": "mine.safetensors"}) == Path("mine.safetensors")


def test_what_is_fitted_on_is_not_attacked(configuration: Configuration) -> None:
    result = SensorDetections(configuration)("fitted", 1, DETECTIONS_FORMAT)
    counts, frames = mismatch_counts(Kept(result), "fitted", FROM_0_3)  # type: ignore[arg-type]
    assert frames == ["0000000001"]
    assert counts.shape == (1, 5, len(IOUS), 2, 2)
    assert (counts[..., 0, 0] == 0).all()
    assert np.isnan(counts).sum() == 5 * len(IOUS) * 3
    told = {row.setting for row in result.detections}
    assert {setting for setting in told if " clean in " not in setting} == {"fitted truth"}


def test_a_sensor_that_sees_more_or_less_than_another_is_a_mismatch(
    configuration: Configuration,
) -> None:
    hidden = set()
    work = SensorDetections(configuration)
    results = [work("judged", number, DETECTIONS_FORMAT) for number in range(3)]
    counts, frames = mismatch_counts(Kept(*results), "judged", FROM_0_3)  # type: ignore[arg-type]
    assert len(frames) == 3
    for number, result in enumerate(results):
        boxes = boxes_of(result)
        assert boxes[truth_setting("judged"), 0.0].category.tolist() == ["Car", "DontCare"]
        clean, spoofed = (
            boxes[f"judged lidar {state} in 2", 0.0] for state in ("clean", "attacked")
        )
        patch = boxes[PATCH, 0.0]
        assert not taken_for_an_obstacle(clean, patch)
        assert taken_for_an_obstacle(spoofed[spoofed.score > 0.3], patch)
        cars = {
            (camera, state): len(boxes[f"judged {camera} {word} in {camera}", 0.0])
            for camera in CAMERAS
            for state, word in enumerate(("clean", "attacked"))
        }
        hidden |= {camera for camera in CAMERAS if not cars[camera, 1]}
        for column, (i, k) in enumerate(KITTI_SYSTEM.pairs()):
            camera = CAMERAS[k - 1]
            for first, second in np.ndindex(2, 2):
                if i:
                    expected = abs(cars[CAMERAS[i - 1], first] - cars[camera, second])
                else:
                    # The phantom, and the car if the camera does not see it.
                    expected = first + 1 - cars[camera, second]
                assert counts[number, column, 0, first, second] == expected
    assert hidden, "no facula hides the car: the test says little"


def test_boxes_count_from_the_working_point_of_clean_frames_on(
    configuration: Configuration,
) -> None:
    work = SensorDetections(configuration)
    kept = Kept(*(work("fitted", number, DETECTIONS_FORMAT) for number in range(2)))
    found = score_thresholds(kept, {})  # type: ignore[arg-type]
    assert found["camera"] == ScoreThreshold(1.0, 1.0, 1.0)
    assert found["lidar"] == ScoreThreshold(1.0, 1.0, 1.0)
    chosen = score_thresholds(kept, {"score_threshold": 0.7})  # type: ignore[arg-type]
    assert {point.score for point in chosen.values()} == {0.7}
    nothing_labelled = score_thresholds(Kept(), {})  # type: ignore[arg-type]
    assert {point.score for point in nothing_labelled.values()} == {USUAL}


def test_the_same_cell_comes_to_the_same(configuration: Configuration) -> None:
    one, other = (SensorDetections(configuration)("judged", 0, DETECTIONS_FORMAT) for _ in range(2))
    assert list(one.measurements) == list(other.measurements)
    for ours, theirs in zip(one.detections, other.detections, strict=True):
        assert (ours.setting, ours.boxes.score.tolist()) == (
            theirs.setting,
            theirs.boxes.score.tolist(),
        )


def test_sizes_of_an_attack_stand_at_one_place_and_grow(configuration: Configuration) -> None:
    # By this seed the bogus return stands 6.3 m away, well before the wall.
    result = AttackSizes(replace(configuration, seed=3))("judged", 0, EVIDENCE_FORMAT)
    boxes, values = boxes_of(result), values_of(result)
    assert values["sizes judged", "error", 0.0] < 0.05
    wide = [values["sizes lidar", "error", width] for width in WIDTHS]
    assert wide == sorted(wide)
    assert wide[-1] > 0.02
    # A scan says nothing of brightness.
    assert {values["sizes lidar", "brightness", width] for width in WIDTHS} == {
        values["sizes judged", "brightness", 0.0]
    }
    covered = [values["sizes camera", COVERED, radius] for radius in RADII]
    assert covered == sorted(covered)
    assert 0 < covered[0] < 0.02
    lit = [values["sizes camera", "brightness", radius] for radius in RADII]
    assert lit[-1] > lit[0] >= values["sizes judged", "brightness", 0.0]
    assert {key for key in boxes if key[0] == "sizes lidar"} == {
        ("sizes lidar", size) for size in (0.0, *WIDTHS)
    }
    assert len(boxes["sizes lidar", 0.0]) == 1
    assert len(boxes["sizes lidar", 0.5]) == 3
    assert len(boxes["sizes camera", 0.0]) == 1
    places = np.array([boxes["sizes lidar", width].location[1, [0, 2]] for width in WIDTHS])
    # The beams, 2 cm apart there, meet a narrow return not quite symmetrically.
    assert np.ptp(places, axis=0).max() < 0.05
    assert len(boxes["sizes truth", 0.0]) == 2


def test_without_detectors_disparity_errors_are_left(configuration: Configuration) -> None:
    alone = {**configuration.options, "sensitivity_lidar": "", "sensitivity_image": ""}
    asked = replace(configuration, options=alone)
    assert size_inputs(asked) == {}
    result = AttackSizes(asked)("judged", 0, EVIDENCE_FORMAT)
    assert [row.setting for row in result.detections] == ["sizes truth"]
    fitted = AttackSizes(asked)("fitted", 0, EVIDENCE_FORMAT)
    assert {row.setting for row in fitted.measurements} == {"sizes fitted"}
    assert not fitted.detections


def test_what_a_real_drive_shows_is_what_its_tracklets_project_to(
    tmp_path: Path, walls: ModuleType
) -> None:
    root = write_drive(walls, tmp_path, 1)
    folder = root / "2026_01_01" / "2026_01_01_drive_0001_sync"
    frame = KittiRaw(root).drive("0001").frame(0)
    labelled = truth_of(frame, 2)
    assert labelled is not None
    assert labelled.category.tolist() == ["Car", "DontCare"]
    (folder / "label_02/data/0000000000.txt").unlink()
    assert truth_of(frame, 2) is None
    one = np.zeros((1, 3))
    cars = [
        Tracklet("Car", np.array([1.5, 1.6, 4.0]), 0, np.array([[x, 0, -1.7]]), one,
                 np.ones(1, int), np.zeros(1, int), np.zeros(1, int))
        for x in (12.0, -12.0)
    ]  # fmt: skip
    write_tracklets(folder / "tracklet_labels.xml", cars)
    seen = truth_of(frame, 2)
    assert seen is not None
    assert len(seen) == 1
    assert seen.box2d is not None
    corners = [[x, y, z] for x in (10, 14) for y in (-0.8, 0.8) for z in (-1.7, -0.2)]
    in_camera = transform_points(walls.RIG.calibration.velodyne_to_camera, corners)
    u, v = (200 * in_camera[:, axis] / in_camera[:, 2] for axis in (0, 1))
    u += 120 + 200 * 0.28 / in_camera[:, 2]
    v += 60
    # Of the world's tilt, a box that stands upright in the camera frame knows nothing.
    np.testing.assert_allclose(seen.box2d[0], [u.min(), v.min(), u.max(), v.max()], atol=1.0)
    assert truth_of(walls.wall(0), 2) is None
