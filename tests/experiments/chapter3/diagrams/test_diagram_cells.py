"""Walls of dots under every attack of the diagrams; what sensors and detectors see of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments.chapter3.diagrams import object_cells
from avsec_gym.experiments.chapter3.diagrams.evidence_cells import (
    POINTS,
    DiagramEvidence,
    camera_of,
    clean_name,
    diagram_cells,
    fitted_kind,
    judged_kind,
    only,
)
from avsec_gym.experiments.chapter3.diagrams.object_cells import (
    DiagramObjects,
    believed_setting,
    seen_setting,
)
from avsec_gym.experiments.chapter3.diagrams.scan_rings import kept_rings, on_rings, rings_of
from avsec_gym.experiments.chapter3.diagrams.settings import DiagramSettings
from avsec_gym.experiments.chapter3.diagrams.variant import CAMERA, Variant
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import bits, measured
from avsec_gym.experiments.chapter3.objects.believed_points import ATTACKED, CLEAN, score_name
from avsec_gym.experiments.chapter3.recordings import FITTED, JUDGED, SYSTEM, recordings_of
from avsec_gym.frame import SensorFrame
from avsec_gym.runs.catalogue import experiment
from avsec_gym.runs.experiment import CellResult, Configuration
from avsec_gym.sensor_system import LIDAR
from avsec_gym.validation.benign_changes import BENIGN_CHANGES
from avsec_gym.validation.evidence.evidence import EVIDENCE_FORMAT
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.state_posterior import state_vectors

SMALL = {
    "matchers": "sgbm,sgbm_filled",
    "scans": [0, 2500],
    "forms": "plane,shell",
    "points": [0, 5000],
    "lights": "gaussian,flat",
    "sizes": [0.2],
    "strengths": [5.0, 255.0],
}


@pytest.fixture(scope="module")
def small(walls: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Configuration:
    root = tmp_path_factory.mktemp("walls")
    judged = walls.write_labelled_drives(root / "judged", 2, 1, distance=30.0)
    fit = walls.write_labelled_drives(root / "fit", 2, 1, first=1000, distance=30.0)
    return Configuration(str(judged), options={**SMALL, "fit": str(fit)})


def shares(result: CellResult, kind: str, position: int | None) -> dict[str, float]:
    state = state_vectors(len(SYSTEM))[0] if position is None else only(position)[0]
    setting = f"{kind} {bits(state)}"
    return {row.name: row.value for row in result.measurements if row.setting == setting}


def test_cells_are_those_of_every_frame_and_matcher(small: Configuration) -> None:
    found = diagram_cells(small)
    by_work = [cell.work.rpartition(":")[2] for cell in found]
    assert by_work == ["DiagramEvidence"] * 8 + ["DiagramObjects"] * 4
    assert len({cell.id for cell in found}) == len(found)
    none = replace(small, options={**small.options, "believers": ""})
    assert {cell.work for cell in diagram_cells(none)} == {found[0].work}
    diagrams = experiment("diagrams")
    assert set(SMALL) < set(diagrams.options)


@pytest.mark.parametrize("matcher", ["sgbm", "sgbm_filled"])
def test_a_judged_frame_has_the_evidence_of_every_attack(
    small: Configuration, matcher: str
) -> None:
    work = DiagramEvidence(small)
    result = work(JUDGED, 0, 1, matcher, EVIDENCE_FORMAT)
    camera = camera_of(0)
    clean = shares(result, judged_kind(matcher, clean_name(0)), None)
    error, triple = measured("error", (0, 2, 3)), measured("brightness", (0, 2, 3))
    assert clean[error] < 0.1
    for variant in DiagramSettings.of(small).variants():
        position = 0 if variant.sensor == LIDAR else camera
        found = shares(result, judged_kind(matcher, variant.name), position)
        assert set(found) == set(clean), variant
        if variant.sensor == LIDAR:
            before = shares(result, judged_kind(matcher, clean_name(variant.scan)), None)
            # A bogus object before the wall contradicts the cameras, the more the denser it is.
            assert (found[error] > before[error]) or not variant.amount
        elif variant.amount == 255.0:
            assert found[triple] > clean[triple] + 0.01
    counts = {row.setting: row.value for row in result.measurements if row.name == POINTS}
    assert counts[judged_kind(matcher, Variant(LIDAR, "plane", 5000).name)] == 5000
    whole, thin = (
        counts[judged_kind(matcher, Variant(LIDAR, "plane", 0, scan=scan).name)]
        for scan in (0, 2500)
    )
    assert 0 < thin < whole
    for change in BENIGN_CHANGES:
        found = shares(result, judged_kind(matcher, f"benign {change}"), camera)
        assert set(found) == set(clean)


def test_dense_points_move_e_more_and_in_thin_scans_even_more(small: Configuration) -> None:
    result = DiagramEvidence(small)(JUDGED, 0, 1, "sgbm", EVIDENCE_FORMAT)
    error = measured("error", (0, 2, 3))
    found = {
        (scan, points): shares(
            result, judged_kind("sgbm", Variant(LIDAR, "plane", points, scan=scan).name), 0
        )[error]
        for scan in (0, 2500)
        for points in (0, 5000)
    }
    assert found[0, 0] < found[0, 5000] < found[2500, 5000]


def test_a_fitted_frame_has_every_state_in_every_scan(small: Configuration) -> None:
    result = DiagramEvidence(small)(FITTED, 1, 1, "sgbm", EVIDENCE_FORMAT)
    settings = {row.setting for row in result.measurements}
    assert settings == {
        f"{fitted_kind('sgbm', scan)} {bits(state)}"
        for scan in (0, 2500)
        for state in state_vectors(len(SYSTEM))
    }
    # What two cameras see does not depend on the scan.
    holes, error = measured("holes", (2, 3)), measured("error", (0, 2, 3))
    values = [
        {row.name: row.value for row in result.measurements
         if row.setting == f"{fitted_kind('sgbm', scan)} 0000"}
        for scan in (0, 2500)
    ]  # fmt: skip
    assert values[0][holes] == values[1][holes]
    assert values[0][error] != values[1][error] or values[0][error] == 0


def test_the_same_cell_gives_the_same(small: Configuration) -> None:
    one, two = (
        DiagramEvidence(small)(JUDGED, 1, 1, "sgbm", EVIDENCE_FORMAT).measurements for _ in range(2)
    )
    assert one == two


class Believer:
    """Takes whatever stands before the wall for a car."""

    name = "believer"

    def detect(self, frame: SensorFrame) -> Boxes3D:
        points = frame.points[:, :3] @ frame.calibration.velodyne_to_camera[:3, :3].T
        points = points + frame.calibration.velodyne_to_camera[:3, 3]
        near = points[(points[:, 2] > 4) & (points[:, 2] < 13.5)]
        if len(near) < 30:
            return Boxes3D.empty()
        place = near.mean(axis=0)
        size = np.maximum(np.ptp(near, axis=0), 0.5)
        return Boxes3D(
            location=np.array([[place[0], near[:, 1].max(), place[2]]]),
            dimensions=np.array([[size[1], size[0], size[2]]]),
            rotation_y=np.array([np.pi / 2]),
            score=np.ones(1),
            category=np.array(["Car"]),
        )


class Blind:
    """Sees bright images alone."""

    name = "blind"

    def detect(self, frame: SensorFrame, camera: int) -> Boxes3D:
        bright = frame.image(camera).mean() > 55
        return Boxes3D(
            location=np.zeros((1, 3)), dimensions=np.ones((1, 3)), rotation_y=np.zeros(1),
            score=np.ones(1), category=np.array(["Car"]),
            box2d=np.array([[10.0, 10, 90, 90]]),
        )[[0] if bright else []]  # fmt: skip


def test_detectors_see_every_attack(small: Configuration, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(object_cells, "lidar_detector", lambda name, options: Believer())
    monkeypatch.setattr(object_cells, "image_detector", lambda name, options: Blind())
    work = DiagramObjects(small)
    result = work(JUDGED, 0, 1)
    rows = {(row.setting, row.name): row.value for row in result.measurements}
    for scan in (0, 2500):
        setting = believed_setting(Variant(LIDAR, "shell", 5000, scan=scan).name)
        assert rows[setting, score_name("pixor", ATTACKED)] == 1.0
        assert np.isnan(rows[setting, score_name("pixor", CLEAN)])
    boxes = {row.setting: row.boxes for row in result.detections}
    camera = int(SYSTEM.sensors[camera_of(0)])
    lights = {strength: Variant(CAMERA, "gaussian", strength, 0.2) for strength in (5.0, 255.0)}
    counts = {
        strength: len(boxes[seen_setting("faster_rcnn", JUDGED, light.name, camera)])
        for strength, light in lights.items()
    }
    assert counts == {5.0: 0, 255.0: 1}
    variants = DiagramSettings.of(small).variants()
    lit, spoofed = (sum(variant.sensor == what for variant in variants) for what in (CAMERA, LIDAR))
    # Truth; two clean images; of two scans by two detectors, and of each bogus object by the
    # first, what both cameras see; and an image for each light.
    assert len(boxes) == 1 + 2 + 2 * 2 * 2 + 2 * spoofed + lit
    fitted = work(FITTED, 0, 1)
    assert len(fitted.detections) == 1 + 2 + 2 * 2 * 2


def test_a_thinned_scan_keeps_whole_rings_and_as_many_as_fit(walls: ModuleType) -> None:
    points = walls.wall(0).points
    assert kept_rings(points, 0) is None
    assert kept_rings(points, len(points)) is None
    assert on_rings(points, None) is points
    rings = rings_of(points)
    counts = np.bincount(rings, minlength=64)
    for most in (500, 2500, 4000):
        kept = kept_rings(points, most)
        assert kept is not None
        thin = on_rings(points, kept)
        assert 0 < len(thin) <= most
        assert len(thin) == sum(counts[ring] for ring in kept)
        more = ((2 * np.arange(len(kept) + 1) + 1) * 64 // (2 * (len(kept) + 1))).astype(int)
        assert counts[more].sum() > most
    assert len(kept_rings(points, 1) or ()) == 1


def test_rings_are_the_nearest_of_the_lidars() -> None:
    from avsec_gym.attacks.lidar_spoofing import RING_ELEVATIONS, lidar_beams

    beams = np.c_[10 * lidar_beams(0.3), np.ones(64 * 2007)].astype(np.float32)
    assert (rings_of(beams).reshape(64, -1) == np.arange(64)[:, None]).all()
    random = np.random.default_rng(0).normal(0, 10, (500, 4)).astype(np.float32)
    elevation = np.arctan2(random[:, 2], np.hypot(random[:, 0], random[:, 1]))
    nearest = np.abs(elevation[:, None] - RING_ELEVATIONS).argmin(axis=1)
    np.testing.assert_array_equal(rings_of(random), nearest)


@pytest.mark.parametrize(
    "wrong",
    [
        {"matchers": "sgm"}, {"matchers": "psmnet_published"}, {"forms": "ball"}, {"points": []},
        {"points": [-1]}, {"points": [1.5]}, {"lights": "green"}, {"sizes": [0.0]},
        {"strengths": [-1.0]}, {"scans": [-5]}, {"scans": []}, {"judged_assets": "mine"},
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_before_the_first_frame(
    small: Configuration, wrong: dict[str, Any], tmp_path: Path
) -> None:
    asked = replace(small, options={**small.options, **wrong})
    if "judged_assets" in wrong:
        asked = replace(asked, scenarios="procedural")
        with pytest.raises(ConfigurationError):
            recordings_of(asked, JUDGED)
        return
    with pytest.raises(ConfigurationError):
        diagram_cells(asked)


def test_the_published_network_takes_the_weights_that_are_given() -> None:
    asked = {"matchers": "psmnet_published", "psmnet_published": "w.safetensors"}
    [found] = DiagramSettings.of(Configuration(options=asked)).depths().values()
    expected = {"name": "psmnet", "configuration": "full", "weights": "w.safetensors"}
    assert found == PairDepth(expected)
