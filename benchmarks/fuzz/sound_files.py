"""A sound file of each kind that users give, small, made by the project's own writers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

CALIBRATION = (
    "P0: 721 0 609 0 0 721 172 0 0 0 1 0\n"
    "P1: 721 0 609 -387 0 721 172 0 0 0 1 0\n"
    "P2: 721 0 609 44.8 0 721 172 0.2 0 0 1 0.0027\n"
    "P3: 721 0 609 -339 0 721 172 2.2 0 0 1 0.0027\n"
    "R0_rect: 1 0 0 0 1 0 0 0 1\n"
    "Tr_velo_to_cam: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27\n"
    "Tr_imu_to_velo: 1 0 0 -0.81 0 1 0 0.32 0 0 1 -0.8\n"
)
LABELS = (
    "Car 0.00 1 -1.85 733.06 182.54 934.34 317.95 1.45 1.49 3.79 2.73 1.60 9.79 -1.58\n"
    "DontCare -1 -1 -10 579.44 175.79 595.04 188.10 -1 -1 -1 -1000 -1000 -1000 -10\n"
    "Van 0.25 0 -0.00 10.00 20.00 30.00 40.50 2.00 1.90 5.00 -3.00 1.70 20.00 -0.00\n"
)
DETECTIONS = (
    "Car -1 -1 -1.85 733.06 182.54 934.34 317.95 1.45 1.49 3.79 2.73 1.60 9.79 -1.58 0.97\n"
    "Car -1 -1 1.57 10.00 120.00 90.00 190.50 1.50 1.60 4.00 -3.00 1.70 20.00 1.43 1.20\n\n"
)
TRACKS = "".join(
    f"{frame} {track} Car 0 0 -1.8 733.06 182.5 934.3 317.9 1.45 1.49 3.79 {x} 1.60 9.79 -1.58\n"
    for frame in range(3)
    for track, x in ((0, 2.73), (1, -3.5))
)

VALIDATION = {"sensors": ["lidar", 3, 2], "seed": 0}
WORLD_SETTINGS = {"suite": "mixed", "frames": 1, "seed": 0}


def image(path: Path) -> None:
    """A camera's PNG."""
    from avsec_gym.kitti.sensor_files import write_image

    write_image(path, np.random.default_rng(0).integers(0, 255, (24, 40, 3), np.uint8))


def scan(path: Path) -> None:
    """A scan of 300 points."""
    from avsec_gym.kitti.sensor_files import write_points

    write_points(path, _points(300))


def disparity(path: Path) -> None:
    """A map with holes."""
    from avsec_gym.kitti.map_files import write_disparity

    values = np.random.default_rng(0).uniform(1, 90, (24, 40)).astype(np.float32)
    values[::3] = np.nan
    write_disparity(path, values)


ODOMETRY_CALIBRATION = "".join(
    line.replace("Tr_velo_to_cam", "Tr") + "\n"
    for line in CALIBRATION.splitlines()
    if not line.startswith(("R0_rect", "Tr_imu"))
)


def raw_calibration(folder: Path) -> None:
    """Three files of a day."""
    from avsec_gym.kitti.calibration import read_calibration
    from avsec_gym.kitti.raw_calibration import write_raw_calibration

    path = folder / "object.txt"
    path.write_text(CALIBRATION)
    write_raw_calibration(folder, read_calibration(path), image_size=(40, 24))
    path.unlink()


def oxts(folder: Path) -> None:
    """Three measurements."""
    from avsec_gym.kitti.oxts import write_oxts
    from avsec_gym.kitti.oxts_poses import oxts_from_poses

    poses = np.tile(np.eye(4), (3, 1, 1))
    poses[:, 0, 3] = [0.0, 1.0, 2.0]
    write_oxts(folder, oxts_from_poses(poses))


def oxts_table(folder: Path) -> None:
    """The same in one file, as the tracking benchmark has them."""
    oxts(folder)
    lines = [path.read_text() for path in sorted(folder.glob("*.txt"))]
    for path in folder.glob("*.txt"):
        path.unlink()
    (folder / "0000.txt").write_text("".join(lines))


def hub_weights(folder: Path) -> None:
    """Small weights as they lie on the hub."""
    from avsec_gym.hub.detectors import export_weights

    weights(folder / "tiny.safetensors")
    export_weights(folder / "tiny.safetensors", folder, "mit")


def timestamps(path: Path) -> None:
    """Ten times, 0.1 s apart."""
    from avsec_gym.kitti.timestamps import write_timestamps

    begin = np.datetime64("2026-01-01T12:00:00.000000789", "ns")
    write_timestamps(path, begin + 100_000_000 * np.arange(10))


def tracklets(path: Path) -> None:
    """A car over two frames."""
    from avsec_gym.kitti.tracklets import Tracklet, write_tracklets

    car = Tracklet(
        category="Car", dimensions=np.array([1.5, 1.6, 4.0]), first_frame=1,
        translation=np.array([[20.0, 2.0, -1.7], [19.0, 2.0, -1.7]]),
        rotation=np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.2]]), state=np.array([2, 1]),
        occlusion=np.array([0, 1]), truncation=np.array([0, 1]),
    )  # fmt: skip
    write_tracklets(path, [car, car])


def primitives(path: Path) -> None:
    """A small set of motion primitives."""
    from avsec_gym.planners.primitive_files import write_primitives
    from avsec_gym.planners.primitives import generate_primitives

    write_primitives(generate_primitives((6.0, 8.0), steering_angles=5), path)


def commonroad(path: Path) -> None:
    """A planning problem of a procedural layout, with standing and moving obstacles."""
    from avsec_gym.scenario.commonroad import write_commonroad
    from avsec_gym.scenario.intention import Intention
    from avsec_gym.scenario.scene_sets import procedural_scenes

    scenes = procedural_scenes(20, seed=3).labelled
    scene = max(scenes, key=lambda scene: int(scene.boxes.moving.sum()))
    write_commonroad(scene.problem(Intention.LEFT), path)


def run(folder: Path) -> None:
    """A finished run of four cells."""
    import tiny_run

    done = tiny_run.make(folder)
    assert not done.failures, done.failures


def patch(path: Path) -> None:
    """A patch with its card."""
    from avsec_gym.attacks.patch_files import Patch, PatchCard, save_patch

    noise = Patch.noise(radius=6.0)
    save_patch(path, Patch(noise.pixels, noise.radius, PatchCard(data={"frames": 3}, epochs=2)))


def object_scan(path: Path) -> None:
    """What a LiDAR saw of a car."""
    from avsec_gym.attacks.object_scan import ObjectScan, write_object_scan

    write_object_scan(path, ObjectScan(_points(40), (1.5, 1.6, 4.0), (-12.0, 3.0)))


def network() -> object:
    """A network of three tensors, the same each time."""
    import torch
    from torch import nn

    torch.manual_seed(0)
    return nn.Sequential(nn.Conv2d(3, 4, 3), nn.BatchNorm2d(4), nn.Conv2d(4, 2, 1))


def weights(path: Path) -> None:
    """Weights with their card."""
    from avsec_gym.perception.weights.model_card import ModelCard
    from avsec_gym.perception.weights.store import save_weights

    card = ModelCard("tiny", configuration={"width": 4}, metrics={"ap": 0.5}, steps=10)
    save_weights(path, network(), card)  # type: ignore[arg-type]


def published(path: Path) -> None:
    """A checkpoint as other repositories publish it."""
    import torch

    torch.save(network().state_dict(), path)  # type: ignore[attr-defined]


def training(folder: Path) -> None:
    """The state of a training that was stopped."""
    import torch

    from avsec_gym.perception.training.checkpoint import Checkpoint, save_checkpoint

    trained: Any = network()
    optimizer = torch.optim.AdamW(trained.parameters())
    sum(value.sum() for value in trained.parameters()).backward()
    optimizer.step()
    state = trained.state_dict()
    save_checkpoint(
        folder,
        Checkpoint(
            {"seed": 0}, step=7, trained=state, average=state, optimizer=optimizer.state_dict(),
            best=0.5,
        ),
    )  # fmt: skip


def thresholds(path: Path) -> None:
    """Thresholds of thirty clean frames."""
    from avsec_gym.validation.thresholds import ThresholdTable

    system, on = _fitted_on()
    shares = np.random.default_rng(0).uniform(0, 0.3, (30, len(system.triples), 4))
    ThresholdTable(on, shares).write(path)


def likelihood(path: Path) -> None:
    """A likelihood of forty frames in all states."""
    from avsec_gym.validation.evidence.evidence import evidence_scopes
    from avsec_gym.validation.likelihood.likelihood_fit import LikelihoodSamples, fit_likelihood
    from avsec_gym.validation.state_posterior import state_vectors

    system, on = _fitted_on()
    frames = 40
    states = np.tile(state_vectors(len(system)), (frames, 1))
    generator = np.random.default_rng(0)
    touched = np.stack([states[:, s].any(axis=1) for s in evidence_scopes(system)], axis=1)
    evidence = np.clip(generator.beta(1, 12, touched.shape) + 0.4 * touched, 0, 1)
    samples = LikelihoodSamples(evidence, states, np.repeat(np.arange(frames), 2 ** len(system)))
    fit_likelihood(on, samples).write(path)


def data_set(folder: Path) -> None:
    """The manifest of a data set of the procedural world that is complete."""
    from avsec_gym.world.export.manifest import list_files, new_manifest, write_manifest

    (folder / "training" / "label_2").mkdir(parents=True)
    (folder / "training" / "label_2" / "000000.txt").write_text(LABELS)
    files = list_files(folder)
    manifest = new_manifest(WORLD_SETTINGS)
    write_manifest(folder, {**manifest, "complete": True, "files": files})


def validation_rows() -> list[dict[str, object]]:
    """Of three frames: sound, an alarm by thresholds, and one by a likelihood."""
    usual: dict[str, object] = {
        "alarm": False, "attacked": [], "truly_attacked": [], "probabilities": None,
        "statuses": {"lidar": "sound", "3": "sound", "2": "sound"},
        "shares": {"lidar,3,2": {"error": 0.1, "hole_share": 0.2}}, "exceeded": [], "damage": {},
        "seconds": 0.4, "locating_seconds": None,
    }  # fmt: skip
    alarm = {
        "alarm": True, "attacked": [3], "truly_attacked": [3],
        "statuses": {"lidar": "sound", "3": "attacked", "2": "cannot tell"},
        "damage": {"3": {"share_of_pixels": 0.25}}, "locating_seconds": 0.1,
    }  # fmt: skip
    share = {"sensors": ["lidar", 3, 2], "share": "densest", "value": 0.4, "threshold": 0.2}
    return [
        {"id": "000000", **usual},
        {"id": "000001", **usual, **alarm, "exceeded": [share]},
        {"id": "000002", **usual, **alarm, "probabilities": {"lidar": 0.1, "3": 0.9, "2": 0.5}},
    ]


def samples(path: Path) -> None:
    """What was measured of three clean frames."""
    rows = [{"id": f"{n:06d}", "measured": [[0.1, 0.2, 0.05, n / 10]]} for n in range(3)]
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))


def label_list(path: Path) -> None:
    """Road types of three images."""
    path.write_text("img_name,label\n000107.png,1\n000108.png,0\n000109.png,1\n")


def json_lines(path: Path) -> None:
    """Learning curves."""
    rows = [{"step": step, "loss": 1.0 / (step + 1), "epoch": 0} for step in range(5)]
    path.write_text("".join(json.dumps(row) + "\n" for row in rows))


def _points(count: int) -> np.ndarray:
    generator = np.random.default_rng(0)
    places = generator.uniform(-60, 60, (count, 3))
    return np.c_[places, generator.uniform(0, 1, count)].astype(np.float32)


def _fitted_on() -> tuple[object, object]:
    from avsec_gym.sensor_system import SensorSystem
    from avsec_gym.validation.fitted_on import FittedOn

    system = SensorSystem(("lidar", 1, 3, 2))
    return system, FittedOn(system, {"name": "sgbm"}, (200.0, 180.0), {"seed": 0})
