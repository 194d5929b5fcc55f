"""Tracklets of a drive: the labelled objects from their first to their last label."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from avsec_gym.geometry import Floats, project, transform_points, wrap_angle
from avsec_gym.kitti.tracklets import (
    BEHIND_IMAGE,
    IN_IMAGE,
    INTERPOLATED,
    LABELLED,
    OUT_OF_IMAGE,
    TRUNCATED,
    Tracklet,
)
from avsec_gym.rig import SensorRig
from avsec_gym.world.drives import DriveScenes

_HIDDEN = 2
"""The raw layout's highest level of occlusion."""


class Sighting(NamedTuple):
    """A labelled object of a frame."""

    actor: int
    """Its id."""
    occlusion: int
    """0 to 3, as in a label file."""
    truncation: float
    """Share outside the image."""


class _Place(NamedTuple):
    """An object in one frame, in the velodyne frame."""

    frame: int
    translation: Floats
    yaw: float


def tracklets_of(
    scenes: DriveScenes, sightings: Mapping[int, Sequence[Sighting]]
) -> list[Tracklet]:
    """Tracklets by their first frame.

    Between two labels an object is there without a break, hidden where it has no label.

    Args:
        scenes: The posed scenes of the drive.
        sightings: The labelled objects by frame.
    """
    seen: dict[int, dict[int, Sighting]] = {}
    for frame in sorted(sightings):
        for sighting in sightings[frame]:
            seen.setdefault(sighting.actor, {})[frame] = sighting
    tracklets = []
    for actor, labels in seen.items():
        first, last = min(labels), max(labels)
        for run in _without_gaps(_places(scenes, actor, first, last)):
            known = [index for index, place in enumerate(run) if place.frame in labels]
            if known:
                run = run[known[0] : known[-1] + 1]
                tracklets.append(_tracklet(scenes, actor, run, labels))
    return sorted(tracklets, key=lambda tracklet: tracklet.first_frame)


def _places(scenes: DriveScenes, actor: int, first: int, last: int) -> list[_Place]:
    """Where an actor is at each frame in which it is on the site."""
    places = []
    for frame in range(first, last + 1):
        actors = scenes.world.instants[frame].actors
        for index in np.flatnonzero(actors.id == actor):
            to_world = scenes.world.ego_poses[frame, 0] @ scenes.rig.velodyne_pose
            from_world = np.linalg.inv(to_world)
            x, y, heading = actors.pose[index]
            forward = from_world[:3, :3] @ [np.cos(heading), np.sin(heading), 0.0]
            translation = transform_points(from_world, [x, y, actors.z[index]])
            places.append(_Place(frame, translation, float(np.arctan2(forward[1], forward[0]))))
    return places


def _without_gaps(places: list[_Place]) -> list[list[_Place]]:
    breaks = [i for i, (a, b) in enumerate(pairwise(places), 1) if b.frame != a.frame + 1]
    return [places[begin:end] for begin, end in pairwise([0, *breaks, len(places)])]


def _tracklet(
    scenes: DriveScenes, actor: int, run: list[_Place], labels: Mapping[int, Sighting]
) -> Tracklet:
    actors = scenes.world.instants[run[0].frame].actors
    index = int(np.flatnonzero(actors.id == actor)[0])
    states, occlusions, truncations = [], [], []
    for place in run:
        sighting = labels.get(place.frame)
        states.append(INTERPOLATED if sighting is None else LABELLED)
        if sighting is None:
            occlusions.append(_HIDDEN)
            truncations.append(_unseen(place, scenes.rig))
        else:
            occlusions.append(min(sighting.occlusion, _HIDDEN))
            truncations.append(TRUNCATED if sighting.truncation > 0 else IN_IMAGE)
    yaw = wrap_angle([place.yaw for place in run])
    return Tracklet(
        category=str(actors.category[index]),
        dimensions=actors.dimensions[index],
        first_frame=run[0].frame,
        translation=np.array([place.translation for place in run]),
        rotation=np.column_stack([np.zeros((len(run), 2)), yaw]),
        state=np.array(states),
        occlusion=np.array(occlusions),
        truncation=np.array(truncations),
    )


def _unseen(place: _Place, rig: SensorRig) -> int:
    """Where an object without a label is: its foot in, out of or behind the image."""
    camera, _ = rig.stereo_pair
    foot = transform_points(rig.calibration.velodyne_to_camera, place.translation)
    pixel, depth = project(rig.calibration.projection(camera), foot)
    if depth <= 0:
        return BEHIND_IMAGE
    inside = (pixel >= 0).all() and (pixel < rig.size).all()
    return IN_IMAGE if inside else OUT_OF_IMAGE
