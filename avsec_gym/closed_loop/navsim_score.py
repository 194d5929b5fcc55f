"""NAVSIM's score of a drive, by its public formula (Dauner et al., NeurIPS 2024, equation 1).

    PDMS = NC * DAC * (5 TTC + 5 EP + 2 C) / 12

NC: no at-fault collision (0.5 where only a standing thing that is no vehicle or person was hit);
DAC: the car's corners never leave the drivable area; TTC: with all speeds and headings kept, no
collision for which the car were to blame lies less than a second ahead, at any time; EP: progress,
as a share of what was to be made; C: comfort, within nuPlan's bounds.  `docs/closed_loop.md` lists
where this differs from NAVSIM's own score.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from avsec_gym.closed_loop.drive_log import DriveContact, DriveLog
from avsec_gym.closed_loop.fault import STANDING, astride, is_ahead, is_behind
from avsec_gym.closed_loop.lanes import Lanes
from avsec_gym.geometry import Floats, rectangle_corners, rectangle_polygons
from avsec_gym.planners.vehicle import BMW_320I

HORIZON = 3.0
"""Seconds that times to collision are looked ahead for."""
TTC_BOUND = 0.95
"""Seconds: NAVSIM looks 0, 0.3, 0.6 and 0.9 s ahead."""
_LOOKS = np.arange(0.0, HORIZON + 1e-9, 0.3)
_EVERY = 0.1
"""Seconds between two instants that are looked at."""
_LEAST_PROGRESS = 5.0
"""Metres; where no more was to be made, NAVSIM counts all progress as made."""
COMFORT = {
    "longitudinal acceleration": (-4.05, 2.40),
    "lateral acceleration": (-4.89, 4.89),
    "jerk": (-8.37, 8.37),
    "longitudinal jerk": (-4.13, 4.13),
    "yaw rate": (-0.95, 0.95),
    "yaw acceleration": (-1.93, 1.93),
}
"""nuPlan's bounds, in m/s2, m/s3, rad/s and rad/s2."""
_ACCELERATION_WINDOW, _JERK_WINDOW, _YAW_WINDOW = 8, 15, 5
"""Instants that NAVSIM (from its second version on) fits a polynomial to, at 10 Hz."""


@dataclass(frozen=True)
class NavsimScore:
    """The five parts of the score, each in [0, 1].

    Args:
        no_collision: NC: 1 without a collision by the car's own fault, 0.5 where only a thing that
            stands was hit.
        drivable: DAC: whether the car stays on the road.
        time_to_collision: TTC: whether the time to a collision stays long enough.
        progress: EP: the share of the possible progress that is made.
        comfort: C: whether the drive is comfortable.
    """

    no_collision: float
    drivable: float
    time_to_collision: float
    progress: float
    comfort: float

    @property
    def total(self) -> float:
        """The score.

        Example:
            >>> NavsimScore(1.0, 1.0, 1.0, 0.5, 0.0).total
            0.625
        """
        weighted = 5 * self.time_to_collision + 5 * self.progress + 2 * self.comfort
        return self.no_collision * self.drivable * weighted / 12


def no_collision(contact: DriveContact | None, fault: bool, log: DriveLog, *, thing: bool) -> float:
    """NC.

    Args:
        contact: The first touch; None: nothing was touched.
        fault: Whether the car is to blame for it.
        log: The drive.
        thing: Whether what was touched is neither a vehicle nor a person.
    """
    if contact is None or not fault:
        return 1.0
    stands = abs(log.speeds[contact.step, contact.actor]) <= STANDING
    return 0.5 if thing and stands else 0.0


def stays_drivable(log: DriveLog, drivable: shapely.Geometry) -> bool:
    """DAC: whether the car's corners stay on the drivable area."""
    corners = rectangle_corners(log.car[:, [0, 1, 3]], BMW_320I.length, BMW_320I.width)
    points = corners.reshape(-1, 2)
    return bool(shapely.contains_xy(drivable, points[:, 0], points[:, 1]).all())


def time_to_collision(log: DriveLog, lanes: Lanes, drivable: shapely.Geometry) -> float:
    """The least time to a collision that the car would be to blame for, s; inf beyond `HORIZON`.

    Car and actors keep speed and heading.  Only what lies ahead counts, and beside it where the car
    is astride two lanes; a standing car has no time to collision.
    """
    stride = max(1, round(_EVERY / log.dt))
    cars, poses, speeds = log.car[::stride], log.poses[::stride], log.speeds[::stride]
    reach = 0.5 * (np.hypot(*log.sizes.T) + np.hypot(BMW_320I.length, BMW_320I.width))
    # Pairs of instants and actors that may touch at some look.
    apart = np.hypot(*np.moveaxis(poses[..., :2] - cars[:, None, :2], -1, 0)) - reach
    closing = HORIZON * (cars[:, 2, None] + np.abs(speeds))
    near = log.present[::stride] & (apart <= closing) & (cars[:, 2, None] > STANDING)
    t, i = np.nonzero(near)
    own = _moved_on(cars[t][:, [0, 1, 3]], cars[t, 2], _LOOKS)
    others = _moved_on(poses[t, i], speeds[t, i], _LOOKS)
    meets = np.hypot(*np.moveaxis((own - others)[..., :2], -1, 0)) <= reach[i, None]
    # The earliest look at which any of them touches; only what touches is asked whether it counts.
    ahead, behind = is_ahead(cars[t], poses[t, i]), is_behind(cars[t], poses[t, i])
    for look, time in enumerate(_LOOKS.tolist()):
        rows = np.flatnonzero(meets[:, look] & ~behind)
        others_there = rectangle_polygons(others[rows, look], *log.sizes[i[rows]].T)
        touching = shapely.intersects(rectangle_polygons(own[rows, look], *_SIZE), others_there)
        for row in rows[touching].tolist():
            if ahead[row] or astride(cars[t[row]], lanes, drivable):
                return float(time)
    return math.inf


_SIZE = (BMW_320I.length, BMW_320I.width)


def _moved_on(poses: Floats, speeds: Floats | float, times: Floats) -> Floats:
    """Poses after some times at constant speed and heading, shape (..., K, 3)."""
    moved = np.repeat(poses[..., None, :], len(times), axis=-2)
    way = np.asarray(speeds)[..., None] * times
    moved[..., 0] += way * np.cos(moved[..., 2])
    moved[..., 1] += way * np.sin(moved[..., 2])
    return moved


def is_comfortable(log: DriveLog) -> bool:
    """C: whether accelerations, jerks and yaw, smoothed as NAVSIM does, stay within `COMFORT`.

    At 10 Hz, by Savitzky-Golay filters.  A drive of less than four instants is comfortable: there
    is nothing to fit.
    """
    stride = max(1, round(_EVERY / log.dt))
    car, dt = log.car[::stride], stride * log.dt
    if len(car) < 4:
        return True
    velocity, heading = car[:, 2], np.unwrap(car[:, 3])
    along, across = np.gradient(velocity, dt), velocity * np.gradient(heading, dt)
    longitudinal, lateral, magnitude = (
        _smoothed(signal, _ACCELERATION_WINDOW, dt)
        for signal in (along, across, np.hypot(along, across))
    )
    signals = {
        "longitudinal acceleration": longitudinal,
        "lateral acceleration": lateral,
        "jerk": _smoothed(magnitude, _JERK_WINDOW, dt, derivative=1),
        "longitudinal jerk": _smoothed(longitudinal, _JERK_WINDOW, dt, derivative=1),
        "yaw rate": _smoothed(heading, _YAW_WINDOW, dt, derivative=1),
        "yaw acceleration": _smoothed(heading, _YAW_WINDOW, dt, derivative=2, order=3),
    }
    return all(
        bool(np.all((signal > COMFORT[name][0]) & (signal < COMFORT[name][1])))
        for name, signal in signals.items()
    )


def _smoothed(
    signal: Floats, window: int, dt: float, *, derivative: int = 0, order: int = 2
) -> Floats:
    """A derivative of polynomials that are fitted to windows of a signal, rounded to 8 decimals.

    Args:
        signal: The signal, shape (T,).
        window: Instants of a window; the whole signal where it is shorter.
        dt: Seconds between two instants.
        derivative: Number of the derivative; 0: the fitted values.
        order: Degree of the polynomials.
    """
    # Here, since it takes as long to load as all else that a drive needs.
    from scipy.signal import savgol_filter

    fitted = savgol_filter(signal, min(window, len(signal)), order, deriv=derivative, delta=dt)
    return np.round(np.asarray(fitted), 8)


def progress_share(progress: float, expected: float) -> float:
    """EP: progress as a share of what was to be made, in [0, 1].

    Args:
        progress: Metres made along the road.
        expected: Metres that were to be made.  NAVSIM takes what its own planner makes; here it is
            the way at the least cruising speed.
    """
    if max(progress, expected) < _LEAST_PROGRESS:
        return 1.0
    return min(max(progress / expected, 0.0), 1.0)
