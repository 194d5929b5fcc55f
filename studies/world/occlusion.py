"""Where KITTI's annotators change their minds about occlusion, found with twins of real frames.

A twin shows how much of each real object is seen when the other labelled objects stand before it;
the label states what the annotator thought.

Run ``python -m studies.world.occlusion --kitti ROOT --frames 400``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from avsec_gym.geometry import Floats
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.world.built_scene import actor_mesh
from avsec_gym.world.capture import Capture, pinhole
from avsec_gym.world.labels import FULLY_VISIBLE, PARTLY_VISIBLE
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.rendering.silhouettes import silhouettes
from avsec_gym.world.site import Surface
from studies.world.command import command, measure_all
from studies.world.frames import TwinScenes
from studies.world.labels import required

LEVELS = 3
"""Visible, partly, largely occluded; the fourth, unknown, is no judgement."""
OBSTACLES = ("Car", "Van", "Truck")


@dataclass(frozen=True)
class SeenShares:
    """How much of each actor is seen, in their order."""

    behind_others: list[float]
    """The share of its pixels behind other actors alone."""
    in_scene: list[float]
    """The share in the whole scene."""
    pixels: list[int]
    """How many it would have alone."""


@dataclass(frozen=True)
class Agreement:
    """Annotated levels (rows) against ours (columns)."""

    thresholds: list[float]
    confusion: list[list[int]]
    """Numbers of objects."""
    agreement: float
    """The share of objects with the same level."""
    kappa: float
    """Cohen's kappa."""


@dataclass(frozen=True)
class OcclusionThresholds:
    """The best thresholds, and how well those in use do."""

    frames: int
    objects: int
    best: Agreement
    in_use: Agreement
    in_use_without_scenery: Agreement
    shares_by_level: list[list[float]]
    """The 10, 25, 50, 75 and 90 % quantiles of seen shares for each annotated level."""


def measure(posed: PosedScene, capture: Capture) -> SeenShares:
    """How much of each actor is seen: behind other actors alone, and in the whole scene."""
    actors, pose = posed.instant.actors, posed.vehicle_to_world[0]
    things = []
    for i in range(1, len(actors)):
        x, y, heading = actors.pose[i].tolist()
        mesh = actor_mesh(actors, i).placed(x, y, float(actors.z[i]), heading)
        things.append(Thing(mesh, Surface.VEHICLE, i))
    if not things:
        return SeenShares([], [], [])
    scene, camera = RayScene(things), pinhole(posed.rig, posed.rig.stereo_pair[0], pose)
    alone = silhouettes(scene, camera, len(actors))
    width, height = camera.size
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    rays = np.stack([u - camera.centre[0], v - camera.centre[1], np.full(u.shape, 1.0)], axis=-1)
    rays[..., :2] /= camera.focal_length
    rays = rays.reshape(-1, 3) @ camera.to_world[:3, :3].T
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    origins = np.broadcast_to(camera.to_world[:3, 3], rays.shape)
    hits = scene.hits(
        np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(rays, np.float32)
    )
    front = scene.object_id[hits.face[hits.face >= 0]]
    ids = capture.geometry.object_id
    area = np.maximum(alone.area, 1)
    behind_others, in_scene = (
        np.minimum(np.bincount(shown, minlength=len(actors)) / area, 1.0)[1:].round(4).tolist()
        for shown in (front, ids[ids >= 0])
    )
    return SeenShares(behind_others, in_scene, alone.area[1:].tolist())


def levels(share: Floats, thresholds: Sequence[float]) -> NDArray[np.int64]:
    """Occlusion levels of seen shares: above the first threshold 0, above the second 1, ..."""
    return np.asarray(np.searchsorted(-np.asarray(thresholds), -share))


def choose_thresholds(share: Floats, judged: NDArray[np.int64]) -> tuple[float, float]:
    """The shares that reproduce the annotators' levels best: those with the highest kappa.

    Args:
        share: The seen shares, shape (N,).
        judged: The annotated levels 0, 1, 2, shape (N,).
    """
    steps = np.round(np.arange(0.02, 0.99, 0.01), 2)
    pairs = [(first, second) for first in steps for second in steps if second < first]
    best = max(pairs, key=lambda pair: agreement(share, judged, pair).kappa)
    return float(best[0]), float(best[1])


def agreement(share: Floats, judged: NDArray[np.int64], thresholds: Sequence[float]) -> Agreement:
    """How far levels of seen shares agree with the annotators'."""
    ours = np.minimum(levels(share, thresholds), LEVELS - 1)
    confusion = np.zeros((LEVELS, LEVELS), np.int64)
    np.add.at(confusion, (judged, ours), 1)
    total = confusion.sum()
    by_chance = float(confusion.sum(0) @ confusion.sum(1)) / total**2
    same = float(np.trace(confusion)) / total
    return Agreement(
        thresholds=[float(threshold) for threshold in thresholds],
        confusion=confusion.tolist(),
        agreement=same,
        kappa=(same - by_chance) / (1.0 - by_chance) if by_chance < 1.0 else 0.0,
    )


def calibrate(options: argparse.Namespace, frames: int | None = None) -> OcclusionThresholds:
    """Twins of real frames: the best thresholds, and how well those in use do.

    Args:
        options: The options of `command.command`.
        frames: How many are drawn; as many as the options ask for if None.

    Raises:
        ConfigurationError: There are no real frames.
        DataError: A label or a calibration is missing or broken.
    """
    nested = required(options.kitti) / "object"
    root = nested if nested.is_dir() else options.kitti
    data = KittiObject(root)
    every = data.ids(having=("label_2", "calib"))
    rng = np.random.default_rng(options.seed)
    ids = tuple(
        sorted(rng.choice(every, min(frames or options.frames, len(every)), replace=False).tolist())
    )
    twins = TwinScenes(root, ids, options.seed)
    rows = measure_all(options, measure, images=False, scenes=twins, frames=len(ids)).of(measure)
    in_scene: list[float] = []
    behind_others: list[float] = []
    judged: list[int] = []
    for id, row in zip(ids, rows, strict=True):
        boxes = data.labels(id)
        assert boxes.occlusion is not None, "labels have it"
        assert boxes.truncation is not None, "labels have it"
        for index in range(len(boxes)):
            level = int(boxes.occlusion[index])
            judgement = boxes.category[index] in OBSTACLES and 0 <= level < LEVELS
            if judgement and row.pixels[index] >= 50 and boxes.truncation[index] < 0.3:
                judged.append(level)
                in_scene.append(row.in_scene[index])
                behind_others.append(row.behind_others[index])
    annotated = np.array(judged)
    seen = np.array(in_scene)
    used = (FULLY_VISIBLE, PARTLY_VISIBLE)
    return OcclusionThresholds(
        frames=len(ids),
        objects=len(judged),
        best=agreement(seen, annotated, choose_thresholds(seen, annotated)),
        in_use=agreement(seen, annotated, used),
        in_use_without_scenery=agreement(np.array(behind_others), annotated, used),
        shares_by_level=[
            np.percentile(seen[annotated == level], [10, 25, 50, 75, 90]).round(3).tolist()
            for level in range(LEVELS)
            if (annotated == level).any()
        ],
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write JSON; returns the exit code."""
    return command(__doc__, arguments, calibrate, frames=400)


if __name__ == "__main__":
    sys.exit(main())
