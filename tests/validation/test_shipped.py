"""What the package ships holds for the rigs that it says, and for no others."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from avsec_gym.attacks.facula import Facula
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.frame import Calibration, SensorFrame
from avsec_gym.rig import KITTI_CAMERAS, SensorRig, camera_rig, kitti_rig
from avsec_gym.sensor_system import KITTI_SYSTEM, LIDAR, SensorSystem
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.likelihood.likelihood_validator import LikelihoodValidator
from avsec_gym.validation.shipped import (
    SHIPPED_SYSTEMS,
    origin_of,
    rig_of,
    shipped_file,
    shipped_fit,
    shipped_on,
    stale,
)
from avsec_gym.validation.state_posterior import state_vectors
from avsec_gym.validation.threshold_validator import ThresholdValidator
from avsec_gym.validation.thresholds import ThresholdTable, read_threshold_table

KINDS = ("thresholds", "likelihood")
SGBM = PairDepth("sgbm")
OBJECT = SensorSystem((LIDAR, 3, 2))


def seen_by(rig: SensorRig) -> SensorFrame:
    """Nothing but the size of the images is looked at."""
    width, height = rig.size
    images = {camera: np.zeros((height, width, 3), np.uint8) for camera in rig.cameras}
    return SensorFrame("000000", rig.calibration, images, np.zeros((1, 4), np.float32))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("system", SHIPPED_SYSTEMS, ids=str)
def test_each_standard_rig_has_its_file(kind: str, system: SensorSystem) -> None:
    path = shipped_fit(kind, system, SGBM, seen_by(kitti_rig()))
    validator = (ThresholdValidator if kind == "thresholds" else LikelihoodValidator)(path)
    on = validator.on
    assert on.system == system
    # r = 1 % is an order statistic of so many or more.
    assert on.data["frames"] >= 100
    said = f"seed {on.data['seed']}, {on.data['frames']} frames; not on this vehicle"
    assert origin_of(on) == f"fitted on procedural drives of KITTI's rig, {said}"
    assert {"sources", "world", "avsec_gym", "drives"} <= set(on.data)
    # They are in what is installed.
    assert path.parent.name == "fits"
    assert "validation/fits/*.json" in (Path(__file__).parents[2] / "pyproject.toml").read_text()


def other_lidar() -> SensorRig:
    rig = kitti_rig()
    moved = rig.calibration.tr_velo_to_cam.copy()
    moved[1, 3] += 1.0
    return SensorRig(replace(rig.calibration, tr_velo_to_cam=moved), rig.size)


def half_as_large() -> SensorRig:
    """With twice the baselines: focal length times baseline is the same."""
    return camera_rig(
        [2 * x for x in KITTI_CAMERAS], focal_length=360.8, centre=(305.0, 86.0), size=(621, 188)
    )


@pytest.mark.parametrize(
    ("rig", "words"),
    [
        (half_as_large(), "a focal length of 361 px, not 722; images of 621 x 188 px"),
        (camera_rig((0.0, 0.54, -0.27, 0.27)), "cameras that stand otherwise"),
        (other_lidar(), "a LiDAR at"),
    ],
    ids=["half as large", "other baselines", "other LiDAR"],
)
def test_another_rig_is_refused(rig: SensorRig, words: str) -> None:
    with pytest.raises(ConfigurationError, match=words):
        shipped_fit("thresholds", KITTI_SYSTEM, SGBM, seen_by(rig))


def test_other_depth_and_other_sensors_are_refused() -> None:
    frame = seen_by(kitti_rig())
    other = PairDepth.from_settings({**SGBM.settings, "nearest": 7.0})
    with pytest.raises(ConfigurationError, match="was fitted with depth by"):
        shipped_fit("thresholds", OBJECT, other, frame)
    with pytest.raises(ConfigurationError, match=r"ships no thresholds .* lidar 1 0, but of lidar"):
        shipped_fit("thresholds", SensorSystem((LIDAR, 1, 0)), SGBM, frame)


def test_another_format_of_the_evidence_is_refused(tmp_path: Path) -> None:
    content = json.loads(shipped_file("thresholds", OBJECT).read_text())
    content["format"] += 1
    shipped_file("thresholds", OBJECT, tmp_path).write_text(json.dumps(content))
    with pytest.raises(DataError, match=f"in format {content['format']}, expected"):
        shipped_fit("thresholds", OBJECT, SGBM, seen_by(kitti_rig()), tmp_path)


def test_other_sources_of_the_evidence_are_said() -> None:
    frame = seen_by(kitti_rig())
    on = shipped_on(OBJECT, SGBM, frame, {"seed": 0, "frames": 3})
    assert not stale(on)
    assert stale(replace(on, data={**on.data, "sources": "0123456789abcdef"}))
    assert not stale(replace(on, data={"recording": "drives", "frames": 3}))
    assert rig_of(frame, SensorSystem((1, 3, 2)))["lidar"] is None


def test_fewer_sensors_say_what_they_say_among_more(wall_of) -> None:  # type: ignore[no-untyped-def]
    """What is measured of all sensors at once is what validators of some of them look at."""
    from avsec_gym.validation.evidence.disparity_error import DisparityErrors
    from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
    from avsec_gym.validation.evidence.evidence import gather_evidence
    from avsec_gym.validation.evidence.state_evidence import StateEvidence
    from avsec_gym.validation.thresholds import shares_of
    from studies.chapter3.shipped_fits.evidence import evidence_of, measured

    every = SensorSystem((LIDAR, 2, 1, 0))
    frame, states = wall_of(1), state_vectors(4)
    covered = Facula(1, radius=40.0, strength=400.0).attack(frame, 3).frame
    bogus = frame.with_points(frame.points[::2] * np.float32(0.5))
    attacked = {LIDAR: bogus, 2: frame, 1: covered, 0: frame}
    rows = measured(StateEvidence(frame, attacked, every, SGBM), states)
    told = evidence_of(rows[None], every)
    for sensors in ((LIDAR, 1, 0), (2, 1, 0), (LIDAR, 2, 0), every.sensors):
        system = SensorSystem(sensors)
        own = told.of(system)
        assert own.states.tolist() == state_vectors(len(system)).tolist()
        for number, state in enumerate(own.states):
            shown = frame
            if LIDAR in sensors and state[sensors.index(LIDAR)]:
                shown = shown.with_points(bogus.points)
            if 1 in sensors and state[sensors.index(1)]:
                shown = shown.with_image(1, covered.image(1))
            errors = DisparityErrors(DisparityMaps(shown, system, SGBM))
            np.testing.assert_allclose(own.elements[0, number], gather_evidence(errors), atol=1e-6)
            expected = shares_of(shown, system, SGBM)
            np.testing.assert_allclose(own.shares[0, number], expected, atol=1e-6)
    with pytest.raises(ConfigurationError, match="not all among"):
        told.of(SensorSystem((LIDAR, 5, 0)))


@pytest.mark.slow
def test_the_first_frame_is_measured_as_it_was() -> None:
    """Whoever changes the evidence raises `fitted_on.FORMAT`, and makes the files anew."""
    from avsec_gym.validation.thresholds import shares_of
    from avsec_gym.world.capture import render
    from avsec_gym.world.drives import drive_scenes

    table: ThresholdTable = read_threshold_table(shipped_file("thresholds", KITTI_SYSTEM))
    posed = drive_scenes(5000 + table.on.data["seed"], 0, 1, rig=kitti_rig())[0]
    capture = render(posed, cameras=(1, 2, 3))
    calibration: Calibration = posed.rig.calibration
    frame = SensorFrame("0", calibration, capture.images, capture.scan and capture.scan.points)
    # Other processors round otherwise, here and there by a pixel of a few thousand.
    np.testing.assert_allclose(shares_of(frame, KITTI_SYSTEM, SGBM), table.shares[0], atol=0.01)
