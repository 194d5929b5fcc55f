from __future__ import annotations

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import avsec_gym  # noqa: F401 - registers the environments.
from avsec_gym.attacks.facula import Facula
from avsec_gym.boxes import Boxes3D
from avsec_gym.closed_loop.loop_scenes import loop_scenes
from avsec_gym.closed_loop.rendered_sensors import RenderedSensors
from avsec_gym.closed_loop.sensor_needs import SensorNeeds, sensing
from avsec_gym.envs.closed_loop_parts import _reduced
from avsec_gym.frame import SensorFrame

DRIVES = {"source": "drives", "count": 4}


class Recorder:
    """A detector that keeps the frames that it is shown."""

    name = "recorder"

    def __init__(self) -> None:
        self.frames: list[SensorFrame] = []

    def detect(self, frame: SensorFrame) -> Boxes3D:
        self.frames.append(frame)
        return Boxes3D.empty()


def first_frame(perception: str, **parts: Any) -> SensorFrame:
    recorder = Recorder()
    env = gym.make(
        "avsec/ClosedLoop-v0", scenarios=DRIVES, perception=perception, detector=recorder, **parts
    )
    env.reset(seed=0)
    return recorder.frames[0]


def test_levels_have_detectors_of_their_own() -> None:
    for level, name in (("lidar", "pixor"), ("stereo", "dsgn"), ("sensors", "dsgn")):
        env = gym.make("avsec/ClosedLoop-v0", scenarios=DRIVES, perception=level)
        env.reset(seed=0)
        assert env.unwrapped.perception.pipeline.detector.name == name  # type: ignore[attr-defined]


def test_a_lidar_level_renders_the_same_scan_and_no_images() -> None:
    alone, whole = first_frame("lidar"), first_frame("sensors")
    assert not alone.images
    assert (alone.points == whole.points).all()
    assert (alone.calibration.projections == whole.calibration.projections).all()


def test_a_stereo_level_renders_no_scan() -> None:
    frame = first_frame("stereo")
    assert sorted(frame.images) == [2, 3]
    assert not frame.has_points


def test_images_are_rendered_at_the_width_that_the_detector_reads() -> None:
    scene = loop_scenes("drives", count=1).scene("drive-000000")
    sensors = sensing(scene, SensorNeeds(scan=False, width=320)).sensors
    assert isinstance(sensors, RenderedSensors)
    frame = sensors(0.0, (0.0, 0.0, 0.0), {})
    height, width, _ = frame.image(2).shape
    assert (width, height) == (320, 97)
    full = scene.sensors.scenes.rig.calibration  # type: ignore[union-attr]
    share = frame.calibration.focal_length(2) / full.focal_length(2)
    assert share == pytest.approx(320 / 1242)


def test_light_lies_at_the_same_place_in_images_of_any_width() -> None:
    """The share of each image that is overexposed, and its middle, are those of full width."""
    light = {"name": "facula", "camera": 2, "radius": 270, "centre": [300, 100]}
    middles = {}
    for level in ("stereo", "sensors"):
        env = gym.make(
            "avsec/ClosedLoop-v0",
            scenarios={"source": "drives", "seed": 1, "count": 1},
            perception=level,
            detector="stereo_rcnn",
            attack=light,
        )
        env.reset(seed=0)
        perception: Any = env.unwrapped.perception  # type: ignore[attr-defined]
        image = perception.frame.image(2)
        other = perception.frame.image(3)
        gained = np.maximum(image.astype(float) - other, 0.0).sum(2)
        height, width = gained.shape
        rows, columns = np.mgrid[:height, :width]
        middles[width] = [
            (gained * columns).sum() / gained.sum() / width,
            (gained * rows).sum() / gained.sum() / height,
        ]
    (narrow, found), (wide, expected) = sorted(middles.items())
    assert narrow < wide == 1242
    assert found == pytest.approx(expected, abs=0.02)


def test_light_stays_where_a_detector_reads_more_pixels_than_the_camera_has() -> None:
    light = Facula(camera=2, centre=(621.0, 100.0))
    assert _reduced(light, 1248) == light
    assert _reduced(light, 621).centre == (310.5, 50.0)
    assert _reduced(replace(light, centre=None), 621).centre is None


def test_scenes_without_rendered_sensors_stay_as_they_are() -> None:
    scene = loop_scenes("layouts", count=1).scene("street-000000")
    assert sensing(scene, SensorNeeds(cameras=())) is scene
