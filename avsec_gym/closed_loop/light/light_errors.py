"""Drawn errors for a light drive: the numbers of `DrawnErrors`, from the same random ones."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, stdtrit

from avsec_gym.box_overlap import overlap_area
from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.error_model.drawn_errors import FOUND, LATENT, TURNED
from avsec_gym.closed_loop.error_model.matching import LATERAL_REACH, radial_reach
from avsec_gym.closed_loop.error_model.model import COMPONENTS, FARTHEST, UNIT, ErrorModel
from avsec_gym.closed_loop.error_model.object_views import HALF_VIEW, RAYS
from avsec_gym.closed_loop.light.light_drive import LightDrive
from avsec_gym.closed_loop.light.road_table import wrapped
from avsec_gym.closed_loop.relative_poses import in_world
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel

_RADIAL, _LATERAL, _TURN, _LOG_LENGTH, _LOG_WIDTH = range(len(COMPONENTS))


class LightErrors:
    """The perception of `ErrorModelPerception`, for a light drive.

    Args:
        model: The errors.
        moving: Whether the planner knows how the objects behind detections move; else everything is
            taken to stand.
    """

    def __init__(self, model: ErrorModel, moving: bool) -> None:
        self.model, self.moving = model, moving
        spreads = [model.spreads[name] for name in COMPONENTS]
        self._found = np.array(model.found)
        self._bias, self._scale, self._growth, self._freedom = np.array(
            [(each.bias, each.scale, each.growth, each.freedom) for each in spreads]
        ).T
        self._places = np.array(model.ghosts.seen).reshape(-1, 6)
        self.begin(0)

    def begin(self, seed: int) -> None:
        """Forget the last drive; the errors of the next one follow from the seed."""
        self._random = np.random.default_rng(seed)
        self._latent: Floats | None = None
        self._ghosts: Floats | None = None
        """World x, y and heading, height, width, length; shape (G, 6)."""
        self._time = 0.0

    def perceive(self, drive: LightDrive) -> Belief:
        """What is found at the present instant; called in the order of time."""
        traffic, frame, car = drive.place.traffic, drive.reached.frame, drive.car
        passed, self._time = drive.elapsed - self._time, drive.elapsed
        pose = (float(car[0]), float(car[1]), float(car[3]))
        there = np.flatnonzero(traffic.present[frame])
        poses, sizes = traffic.poses[frame][there], traffic.sizes[there]
        # Who is found, by normal numbers that are remembered from frame to frame.
        latent = self._remembered(there, len(traffic.sizes), passed)
        probabilities, distance, bearing = _views(
            pose, poses, sizes, traffic.cars[there], self._found
        )
        shares = ndtr(latent)
        seen = np.flatnonzero(shares[:, FOUND] < probabilities)
        # What is wrong with what is found.
        shares = shares[seen]
        errors = stdtrit(self._freedom, shares[:, TURNED + 1 :])
        away = distance[seen]
        errors *= self._scale * np.exp(self._growth * np.minimum(away, FARTHEST)[:, None] / UNIT)
        errors += self._bias
        reach = radial_reach(away)
        errors[:, _RADIAL] = np.clip(errors[:, _RADIAL], -reach, reach)
        errors[:, _LATERAL] = np.clip(errors[:, _LATERAL], -LATERAL_REACH, LATERAL_REACH)
        turned = shares[:, TURNED] < self.model.turned_round
        found, extent = _displaced(poses[seen], sizes[seen], bearing[seen], errors, turned, pose)
        ghosts = self._ghosts_at(pose, passed)
        believed = np.concatenate([found, ghosts[:, :3]])
        speeds = np.zeros(len(believed))
        if self.moving:
            true = traffic.speeds[frame][there]
            speeds[: len(seen)] = _speeds_of(found, extent, true[seen], poses, sizes, true)
        extent = np.concatenate([extent, ghosts[:, [5, 4]]])
        kept = (extent > 0).all(axis=1)
        return Belief(
            drive.elapsed,
            believed[kept],
            extent[kept, 0],
            extent[kept, 1],
            speeds[kept],
            drive.place.scene.road_type,
        )

    def _remembered(self, there: NDArray[np.int64], count: int, passed: float) -> Floats:
        """The normal numbers of those who are there, shape (N, `LATENT`)."""
        if self._latent is None:
            self._latent = np.full((count, LATENT), np.nan)
        kept = np.full(LATENT, math.exp(-passed / self.model.error_seconds))
        kept[FOUND] = math.exp(-passed / self.model.found_seconds)
        fresh = self._random.standard_normal((len(there), LATENT))
        before = self._latent[there]
        fresh = np.where(np.isnan(before), fresh, kept * before + np.sqrt(1 - kept**2) * fresh)
        self._latent[there] = fresh
        return fresh

    def _ghosts_at(self, pose: tuple[float, float, float], passed: float) -> Floats:
        """The ghosts of this instant: some have gone, others have come."""
        model = self.model.ghosts
        if self._ghosts is None:
            self._ghosts, kept = np.zeros((0, 6)), 0.0
        else:
            kept = math.exp(-passed / model.seconds)
            self._ghosts = self._ghosts[self._random.random(len(self._ghosts)) < kept]
        count = int(self._random.poisson(model.rate * (1 - kept)))
        if count:
            new = self._places[self._random.integers(len(self._places), size=count)]
            new[:, :3] = in_world(pose, new[:, :3])
            self._ghosts = np.concatenate([self._ghosts, new])
        return self._ghosts


@kernel(nogil=True)
def _views(
    pose: tuple[float, float, float],
    poses: Floats,
    sizes: Floats,
    cars: NDArray[np.bool_],
    weights: Floats,
) -> tuple[Floats, Floats, Floats]:
    """How surely each object is found, its distance and its bearing, each of shape (N,).

    As `object_views` and `ErrorModel.probabilities`; what lies outside the view has no chance.
    """
    count = len(poses)
    probabilities, distance, bearing = np.zeros(count), np.empty(count), np.empty(count)
    right, left = np.zeros(count), np.zeros(count)
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    # The angles between the outermost corners, around the direction of the centre.
    for i in range(count):
        dx, dy = poses[i, 0] - pose[0], poses[i, 1] - pose[1]
        x, y, heading = cos * dx + sin * dy, cos * dy - sin * dx, poses[i, 2] - pose[2]
        distance[i], bearing[i] = np.hypot(x, y), np.arctan2(y, x)
        ahead_x, ahead_y = 0.5 * sizes[i, 0] * np.cos(heading), 0.5 * sizes[i, 0] * np.sin(heading)
        left_x, left_y = -0.5 * sizes[i, 1] * np.sin(heading), 0.5 * sizes[i, 1] * np.cos(heading)
        for k in range(4):
            a, b = (1.0 if k in (0, 3) else -1.0), (1.0 if k < 2 else -1.0)
            corner_x, corner_y = x + a * ahead_x + b * left_x, y + a * ahead_y + b * left_y
            apart = wrapped(np.arctan2(corner_y, corner_x) - bearing[i])
            right[i], left[i] = min(right[i], apart), max(left[i], apart)
    # Rays across each object: outside the image, or meeting something nearer.
    rays = np.empty(RAYS)
    for i in range(count):
        outside, hidden = 0, 0
        for k in range(RAYS):
            rays[k] = wrapped(bearing[i] + right[i] + (left[i] - right[i]) * (k + 0.5) / RAYS)
            outside += abs(rays[k]) > HALF_VIEW
        if outside == RAYS:
            continue
        for k in range(RAYS):
            for j in range(count):
                if distance[j] < distance[i]:
                    # Both lie in [-pi, pi): a whole turn is all that the difference may be off by.
                    turned = rays[k] - bearing[j]
                    if turned >= np.pi:
                        turned -= 2.0 * np.pi
                    elif turned < -np.pi:
                        turned += 2.0 * np.pi
                    if right[j] <= turned <= left[j]:
                        hidden += 1
                        break
        away = min(distance[i], FARTHEST) / UNIT
        odds = weights[0] + weights[1] * away + weights[2] * away**2
        odds += weights[3] * hidden / RAYS + weights[4] * outside / RAYS
        odds += weights[5] * (0.0 if cars[i] else 1.0)
        probabilities[i] = 1.0 / (1.0 + np.exp(-odds))
    return probabilities, distance, bearing


@kernel(nogil=True)
def _displaced(
    poses: Floats,
    sizes: Floats,
    bearing: Floats,
    errors: Floats,
    turned: NDArray[np.bool_],
    pose: tuple[float, float, float],
) -> tuple[Floats, Floats]:
    """World poses and sizes of detections with their errors."""
    poses, sizes = poses.copy(), sizes.copy()
    for i in range(len(poses)):
        angle = bearing[i] + pose[2]
        cos, sin = np.cos(angle), np.sin(angle)
        radial, lateral = errors[i, _RADIAL], errors[i, _LATERAL]
        poses[i, 0] += cos * radial - sin * lateral
        poses[i, 1] += sin * radial + cos * lateral
        poses[i, 2] += errors[i, _TURN] + (np.pi if turned[i] else 0.0)
        # Tails are heavy, cars are not: a third to three times the size.
        sizes[i, 0] *= np.exp(min(max(errors[i, _LOG_LENGTH], -1.0), 1.0))
        sizes[i, 1] *= np.exp(min(max(errors[i, _LOG_WIDTH], -1.0), 1.0))
    return poses, sizes


@kernel(nogil=True)
def _speeds_of(
    detected: Floats,
    extent: Floats,
    own: Floats,
    poses: Floats,
    sizes: Floats,
    speeds: Floats,
) -> Floats:
    """`matched_speeds` of detections, which move where what they are detections of does."""
    found = np.zeros(len(detected))
    one, other = np.empty(5), np.empty(5)
    for d in range(len(detected)):
        if own[d] == 0.0:
            continue
        one[0], one[1], one[4] = detected[d, 0], detected[d, 1], detected[d, 2]
        one[2], one[3] = extent[d, 0], extent[d, 1]
        best = 0.0
        for i in range(len(poses)):
            other[0], other[1], other[4] = poses[i, 0], poses[i, 1], poses[i, 2]
            other[2], other[3] = sizes[i, 0], sizes[i, 1]
            common = overlap_area(one, other)
            share = common / (one[2] * one[3] + other[2] * other[3] - common)
            if share > best:
                best = share
                backwards = np.cos(detected[d, 2] - poses[i, 2]) < 0
                found[d] = -speeds[i] if backwards else speeds[i]
    return found
