"""Drawn errors for a light drive: the numbers of `DrawnErrors`, from the same random ones."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.box_overlap import overlap_area
from avsec_gym.closed_loop.angles import wrapped
from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.error_model.drawn_errors import FOUND, LATENT, TURNED
from avsec_gym.closed_loop.error_model.drawn_ghosts import DrawnGhosts
from avsec_gym.closed_loop.error_model.matching import LATERAL_REACH, RADIAL_REACH
from avsec_gym.closed_loop.error_model.model import COMPONENTS, FARTHEST, UNIT, ErrorModel
from avsec_gym.closed_loop.error_model.object_views import HALF_VIEW, RAYS
from avsec_gym.closed_loop.light.light_drive import LightDrive
from avsec_gym.closed_loop.light.t_quantiles import quantile_table, t_quantile
from avsec_gym.geometry import Floats
from avsec_gym.kernels import kernel


class _Errors(NamedTuple):
    """An error model as kernels take it; of the components in their order, shape (K,) each."""

    found: Floats
    """Weights of the log-odds of a detection, shape (6,)."""
    bias: Floats
    scale: Floats
    growth: Floats
    quantiles: Floats
    """The table of `quantile_table`."""
    turned_round: float
    moving: bool
    """Whether it is known how things move."""


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
        self._errors = _Errors(
            np.array(model.found, float),
            np.array([each.bias for each in spreads], float),
            np.array([each.scale for each in spreads], float),
            np.array([each.growth for each in spreads], float),
            quantile_table(tuple(each.freedom for each in spreads)),
            float(model.turned_round),
            bool(moving),
        )
        self._ghosts = DrawnGhosts(model.ghosts)
        self.begin(0)

    def begin(self, seed: int) -> None:
        """Forget the last drive; the errors of the next one follow from the seed."""
        self._random = np.random.default_rng(seed)
        self._latent: Floats | None = None
        self._ghosts.begin()
        self._time = 0.0

    def perceive(self, drive: LightDrive) -> Belief:
        """What is found at the present instant; called in the order of time."""
        traffic, frame, car = drive.place.traffic, drive.reached.frame, drive.car
        passed, self._time = drive.elapsed - self._time, drive.elapsed
        present = traffic.present[frame]
        if self._latent is None:
            self._latent = np.full((len(present), LATENT), np.nan)
        fresh = self._random.standard_normal((np.count_nonzero(present), LATENT))
        keeps = (
            math.exp(-passed / self.model.found_seconds),
            math.exp(-passed / self.model.error_seconds),
        )
        _remember(self._latent, present, fresh, keeps)
        pose = (float(car[0]), float(car[1]), float(car[3]))
        ghosts = self._ghosts.at(pose, passed, self._random)
        poses, length, width, speeds = _believed(
            self._errors,
            pose,
            present,
            traffic.poses[frame],
            traffic.sizes,
            traffic.cars,
            traffic.speeds[frame],
            self._latent,
            ghosts,
        )
        return Belief(drive.elapsed, poses, length, width, speeds, drive.place.scene.road_type)


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
    # Invariant: right[i] <= 0 <= left[i], and both bound the corners of object i before k.
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
    # Invariant: `hidden` counts each ray of object i once, however many objects it meets.
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
        # The model's log odds.
        away = min(distance[i], FARTHEST) / UNIT
        odds = weights[0] + weights[1] * away + weights[2] * away**2
        odds += weights[3] * hidden / RAYS + weights[4] * outside / RAYS
        odds += weights[5] * (0.0 if cars[i] else 1.0)
        probabilities[i] = 1.0 / (1.0 + np.exp(-odds))
    return probabilities, distance, bearing


@kernel(nogil=True)
def _remember(
    latent: Floats, present: NDArray[np.bool_], fresh: Floats, keeps: tuple[float, float]
) -> None:
    """Bring the normal numbers of those who are there to this instant.

    Args:
        latent: The normal numbers of all actors, NaN before they were there, shape (N, `LATENT`);
            changed.
        present: Who is there, shape (N,).
        fresh: New ones for those, in their order, shape (P, `LATENT`).
        keeps: How much of who is found, and of all else, is remembered.
    """
    # Invariant: `row` is how many of the first i actors are there, the row of i's fresh numbers.
    row = 0
    for i in range(len(present)):
        if not present[i]:
            continue
        # An autoregressive step of unit variance; who was not there begins with the fresh number.
        for k in range(LATENT):
            kept, new = keeps[0] if k == FOUND else keeps[1], fresh[row, k]
            if not np.isnan(latent[i, k]):
                new = kept * latent[i, k] + np.sqrt(1.0 - kept**2) * new
            latent[i, k] = new
        row += 1


@kernel(nogil=True)
def _believed(
    errors: _Errors,
    pose: tuple[float, float, float],
    present: NDArray[np.bool_],
    all_poses: Floats,
    all_sizes: Floats,
    all_cars: NDArray[np.bool_],
    all_speeds: Floats,
    latent: Floats,
    ghosts: Floats,
) -> tuple[Floats, Floats, Floats, Floats]:
    """Poses, lengths, widths and speeds of what is found, with its errors, and of ghosts."""
    there = np.flatnonzero(present)
    poses, sizes, true = all_poses[there], all_sizes[there], all_speeds[there]
    probabilities, distance, bearing = _views(pose, poses, sizes, all_cars[there], errors.found)
    most = len(there) + len(ghosts)
    found, extent, speeds = np.empty((most, 3)), np.empty((most, 2)), np.zeros(most)
    count = 0
    for i in range(len(there)):
        # Found as likely as the model wants it.
        own = latent[there[i]]
        if not _share(own[FOUND]) < probabilities[i]:
            continue
        found[count], extent[count] = poses[i], sizes[i]
        _displace(found[count], extent[count], errors, own, distance[i], bearing[i] + pose[2])
        if errors.moving:
            speeds[count] = _speed_of(found[count], extent[count], true[i], poses, sizes, true)
        count += (extent[count] > 0.0).all()
    for ghost in ghosts:
        found[count] = ghost[:3]
        extent[count, 0], extent[count, 1], speeds[count] = ghost[5], ghost[4], 0.0
        count += (extent[count] > 0.0).all()
    return found[:count], extent[:count, 0].copy(), extent[:count, 1].copy(), speeds[:count]


@kernel(nogil=True)
def _displace(
    pose: Floats, extent: Floats, errors: _Errors, own: Floats, distance: float, angle: float
) -> None:
    """Change world pose and size of a detection by its errors.

    Args:
        pose: x, y and heading of the detection; changed.
        extent: Length and width.
        errors: The model.
        own: The object's normal numbers, shape (`LATENT`,).
        distance: Metres to the object.
        angle: The line of sight to it, in the world, radians.
    """
    error = np.empty(len(errors.bias))
    away = min(distance, FARTHEST) / UNIT
    for k in range(len(error)):
        drawn = t_quantile(errors.quantiles, k, own[TURNED + 1 + k])
        error[k] = errors.bias[k] + errors.scale[k] * np.exp(errors.growth[k] * away) * drawn
    reach = RADIAL_REACH[0] + RADIAL_REACH[1] * distance
    radial = min(max(error[_RADIAL], -reach), reach)
    lateral = min(max(error[_LATERAL], -LATERAL_REACH), LATERAL_REACH)
    cos, sin = np.cos(angle), np.sin(angle)
    pose[0] += cos * radial - sin * lateral
    pose[1] += sin * radial + cos * lateral
    pose[2] += error[_TURN] + (np.pi if _share(own[TURNED]) < errors.turned_round else 0.0)
    # Tails are heavy, cars are not: a third to three times the size.
    extent[0] *= np.exp(min(max(error[_LOG_LENGTH], -1.0), 1.0))
    extent[1] *= np.exp(min(max(error[_LOG_WIDTH], -1.0), 1.0))


@kernel(nogil=True)
def _share(normal: float) -> float:
    """How much of a standard normal distribution lies below a number."""
    return 0.5 * math.erfc(-normal * math.sqrt(0.5))


@kernel(nogil=True)
def _speed_of(
    detected: Floats, extent: Floats, own: float, poses: Floats, sizes: Floats, speeds: Floats
) -> float:
    """`matched_speeds` of a detection, which moves where what it is a detection of does."""
    if own == 0.0:
        return 0.0
    one, other = np.empty(5), np.empty(5)
    one[0], one[1], one[4] = detected[0], detected[1], detected[2]
    one[2], one[3] = extent[0], extent[1]
    best, found = 0.0, 0.0
    for i in range(len(poses)):
        other[0], other[1], other[4] = poses[i, 0], poses[i, 1], poses[i, 2]
        other[2], other[3] = sizes[i, 0], sizes[i, 1]
        common = overlap_area(one, other)
        share = common / (one[2] * one[3] + other[2] * other[3] - common)
        if share > best:
            best = share
            backwards = np.cos(detected[2] - poses[i, 2]) < 0
            found = -speeds[i] if backwards else speeds[i]
    return found
