"""Drives of connected vehicles of the procedural world, scanned in memory."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from avsec_gym.experiments.chapter4.procedural_instants import ASSETS, scanned_instant
from avsec_gym.experiments.chapter4.settings import FITTED, JUDGED, USUAL, Part
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.world.drives import drive_scenes
from avsec_gym.world.export import clock_offsets, measured_pose, pose_errors
from avsec_gym.world.posed_scenes import PosedScene

_FIRST_SET: dict[Part, int] = {FITTED: 7000, JUDGED: 8000}
"""Numbers of the sets of drives, none of which anything else was made from."""
_REACH = 95.0
"""Metres from a LiDAR beyond which no actor matters to its scan: echoes come from 80 m at most."""


def scanned_drive(seed: int, part: Part, number: int, frames: int) -> Iterator[RecordedInstant]:
    """The instants of a drive as the vehicles measure them, 0.1 s apart.

    Poses and clocks err as under `USUAL`; the errors of poses drift over seconds, and a clock's
    offset stays.

    Args:
        seed: Seed of the run.
        part: `FITTED` or `JUDGED`, which share no place and no assets.
        number: Number of the drive.
        frames: Number of instants.
    """
    name, vehicles = _FIRST_SET[part] + seed, USUAL.vehicles
    scenes = drive_scenes(name, number, frames, vehicles, assets=ASSETS[part])
    offsets = clock_offsets(name, number, vehicles, USUAL.clocks_apart).tolist()
    errors = [pose_errors(name, number, vehicle, frames) for vehicle in range(vehicles)]
    for frame in range(frames):
        id = f"{number:06d}/{frame:06d}"
        posed = within_reach(scenes[frame])
        whole = scanned_instant(posed, offsets, number, frame, id)
        scans = tuple(
            replace(scan, pose=measured_pose(scan.pose, error[frame], USUAL.noise, USUAL.noise))
            for scan, error in zip(whole.scans, errors, strict=True)
        )
        yield replace(whole, scans=scans)


def within_reach(posed: PosedScene) -> PosedScene:
    """A scene without the actors that no LiDAR reaches.

    Much of the time that a scan takes goes into the meshes of actors, of people above all, half of
    whom are out of its reach.

    Args:
        posed: The scene; its sensor vehicles stay.
    """
    instant = posed.instant
    places = instant.actors.pose[:, :2]
    away = np.hypot(*(places[:, None] - places[list(instant.egos)]).T)
    kept = np.flatnonzero((away < _REACH).any(axis=0))
    turn_rate = None if instant.turn_rate is None else instant.turn_rate[kept]
    egos = tuple(int(np.searchsorted(kept, ego)) for ego in instant.egos)
    fewer = replace(instant, actors=instant.actors.pick(kept), egos=egos, turn_rate=turn_rate)
    return replace(posed, instant=fewer)
