"""A package of another author is installed as pip would, and has small frames to look at."""

from __future__ import annotations

import os
import shutil
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from avsec_gym import registry
from avsec_gym.boxes import Boxes3D
from avsec_gym.cli import run
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.rig import camera_rig
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.builder import build_planning_scenario
from avsec_gym.scenario.commonroad import write_commonroad

ROOT = Path(__file__).parents[2]
PACKAGE = Path(__file__).parent / "avsec_others"
RIG = camera_rig([-0.2, 0.3, 0.0, 0.5], focal_length=200.0, centre=(160.0, 60.0), size=(320, 120))
CAR, ASIDE = 10.0, -4.0
"""Metres ahead at which the rear of each frame's car is, and its middle's x in the camera frame."""
FAR = 50.0
"""Metres to the wall behind it."""


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that pip would write for pyproject.toml."""
    site = tmp_path_factory.mktemp("site")
    project = tomllib.loads((PACKAGE / "pyproject.toml").read_text())["project"]
    shutil.copytree(
        PACKAGE / "avsec_others", site / "avsec_others", ignore=shutil.ignore_patterns("__py*")
    )
    about = site / "avsec_others-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    lines = []
    for group, points in project["entry-points"].items():
        lines += [f"[{group}]", *(f"{name} = {place}" for name, place in points.items())]
    (about / "entry_points.txt").write_text("\n".join(lines) + "\n")
    return site


@pytest.fixture
def installed(site: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """As if this process, and those that it starts, had begun with the package there."""
    paths = [str(site), str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))
    monkeypatch.syspath_prepend(site)
    monkeypatch.setattr(registry, "_REGISTERED", {})
    monkeypatch.setattr(registry, "_PLUGINS_LOADED", False)
    yield
    for module in [name for name in sys.modules if name.partition(".")[0] == "avsec_others"]:
        del sys.modules[module]


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three frames with a car beside the way, in KITTI's object layout; a planning problem."""
    root = tmp_path_factory.mktemp("data")
    for number in range(1, 4):
        write_object_frame(root / "training", _frame(number), _label())
    problem = build_planning_scenario(Boxes3D.empty(), road_type=RoadType.STREET, id="free")
    write_commonroad(problem, root / "free.xml")
    return root


def _label() -> Boxes3D:
    return Boxes3D(
        [[ASIDE, 1.65, CAR + 2.0]], [[1.5, 1.6, 4.0]], [-np.pi / 2], [1.0], ["Car"],
        box2d=[[64.0, 63.0, 96.0, 93.0]], truncation=[0.0], occlusion=[0], alpha=[-1.25],
    )  # fmt: skip


def _frame(number: int) -> SensorFrame:
    """Random dots on a wall and on the rear of a car, as both cameras and the LiDAR see them."""
    generator = np.random.default_rng(number)
    wall, rear = (generator.integers(0, 256, size, np.uint8) for size in ((120, 360), (30, 32)))
    images = {}
    for camera, baseline in ((2, 0.0), (3, 0.5)):
        far, near = (round(200.0 * baseline / depth) for depth in (FAR, CAR))
        image = wall[:, far : far + 320].copy()
        image[63:93, 64 - near : 96 - near] = rear
        images[camera] = image[:, :, None].repeat(3, axis=2)
    surfaces = []
    for depth, left, right, top, bottom in ((FAR, -30, 30, -12, 1.6), (CAR, -4.8, -3.2, 0.2, 1.6)):
        x, y = np.meshgrid(np.linspace(left, right, 80), np.linspace(top, bottom, 40))
        surfaces.append(
            np.stack([x.ravel(), y.ravel(), np.full(x.size, depth), np.ones(x.size)], 1)
        )
    # The beams that meet the car do not meet the wall behind it.
    hidden = np.abs(surfaces[0][:, 0] * CAR / FAR - ASIDE) < 0.9
    points = np.concatenate([surfaces[0][~hidden], surfaces[1]])
    scan = (points @ RIG.calibration.camera_to_velodyne.T).astype(np.float32)
    return SensorFrame(f"{number:06d}", RIG.calibration, images, scan)


class Ended(NamedTuple):
    stdout: str
    stderr: str


@pytest.fixture
def avsec(
    installed: None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Any:
    """Runs a command in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def command(*words: Any, code: int = 0) -> Ended:
        assert run([str(word) for word in words]) == code
        return Ended(*capsys.readouterr())

    return command
