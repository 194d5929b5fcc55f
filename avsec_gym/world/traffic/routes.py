"""Lines that travellers follow: lanes, turns, paths, crossings; even and smooth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from avsec_gym.geometry import Floats
from avsec_gym.world.course import Course
from avsec_gym.world.traffic.driving import bend_limits

SPACING = 0.5
"""Metres between the poses of a route."""


@dataclass(frozen=True, eq=False)
class Route:
    """A line to follow.  Places on it are metres from its start.

    Args:
        poses: Position x, y and heading every `SPACING` metres, shape (n, 3); headings without
            jumps.
        width: Width of the widest traveller of the route, metres.
        gate: Place where fronts wait until the way is free; infinite without such a place.
        clear: Place from which on rears block no other traveller; with `gate` it encloses the
            stretch on which others are crossed or joined.
        shown: First and last place of the route within the site.
    """

    poses: Floats
    width: float
    gate: float = np.inf
    clear: float = np.inf
    shown: tuple[float, float] = (-np.inf, np.inf)

    @property
    def length(self) -> float:
        """Metres."""
        return SPACING * (len(self.poses) - 1)

    def limits(self) -> Floats:
        """Highest speeds for the bends at the poses, m/s, shape (n,)."""
        return bend_limits(np.gradient(self.poses[:, 2], SPACING), SPACING)

    def nearest(self, x: float, y: float) -> float:
        """The place on the route that is nearest to a point."""
        distance = ((self.poses[:, :2] - (x, y)) ** 2).sum(axis=1)
        return SPACING * float(distance.argmin())


def along_course(
    course: Course, left: ArrayLike = 0.0, direction: int = 1, margin: float = 0.0
) -> Floats:
    """Poses beside a course, also beyond its ends, where it runs on straight.

    Args:
        course: The line to keep beside.
        left: Distance to the left of the course, metres: a number, or one for each of `stations`.
        direction: Direction of travel: 1 along the course, -1 against it.
        margin: Length of the line beyond both ends, metres.

    Returns:
        Shape (n, 3), evenly spaced, in the order of travel.
    """
    along = stations(course, margin)
    left = np.broadcast_to(np.asarray(left, float), along.shape)
    poses = course.poses(along, left)
    bend = np.gradient(poses[:, 2], along)
    poses[:, 2] += np.arctan2(np.gradient(left, along), 1.0 - bend * left)
    return evenly(poses if direction > 0 else (poses + np.array([0.0, 0.0, np.pi]))[::-1])


def stations(course: Course, margin: float = 0.0) -> Floats:
    """Road coordinates of the course's points, continued by `margin` at both ends."""
    more = int(np.ceil(margin / course.spacing))
    return np.asarray(course.start + course.spacing * np.arange(-more, len(course.points) + more))


def evenly(poses: Floats) -> Floats:
    """The same line with a pose every `SPACING` metres (cubic Hermite between the given ones)."""
    chord = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    pieces = chord / np.sinc(0.5 * np.diff(poses[:, 2]) / np.pi)
    place = np.concatenate([[0.0], np.cumsum(pieces)])
    return hermite(poses, place, np.arange(0.0, place[-1] + 1e-9, SPACING))


def hermite(poses: Floats, place: Floats, wanted: Floats) -> Floats:
    """Poses at wanted places of a line whose poses lie at known ones."""
    index = np.clip(np.searchsorted(place, wanted, side="right") - 1, 0, len(place) - 2)
    piece = place[index + 1] - place[index]
    return between(poses[index], poses[index + 1], piece, (wanted - place[index]) / piece)


def between(one: Floats, two: Floats, length: ArrayLike, share: Floats) -> Floats:
    """Cubic Hermite interpolation between poses `length` apart, shape (N, 3) each.

    Before 0 and after 1 the line runs on straight.
    """
    inside = np.clip(share, 0.0, 1.0)[:, None]
    length = np.broadcast_to(np.asarray(length, float), share.shape)[:, None]
    heading = one[:, 2:] * (1 - inside) + two[:, 2:] * inside
    beyond = (share[:, None] - inside) * length
    begin, end = length * _directions(one), length * _directions(two)
    rest = 1.0 - inside
    places = (
        one[:, :2] * (1 + 2 * inside) * rest**2
        + two[:, :2] * (1 + 2 * rest) * inside**2
        + begin * inside * rest**2
        - end * rest * inside**2
    )
    poses = np.concatenate([places, heading], axis=-1)
    poses[:, :2] += beyond * _directions(poses)
    return poses


def _directions(poses: Floats) -> Floats:
    """Unit vectors along the headings, shape (N, 2)."""
    return np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=-1)


def join(first: Floats, second: Floats, before: float, after: float) -> tuple[Floats, float, float]:
    """Leave one line for another where they meet, by a smooth turn.

    Args:
        first: Evenly spaced poses, as of `along_course`.
        second: The same.
        before: Distance before the meeting point at which the turn begins, metres.
        after: Distance behind it at which the turn ends, on the second line, metres.

    Returns:
        The joined poses, and the places on them where the turn begins and ends.
    """
    meets, met = _nearest_pair(first[:, :2], second[:, :2])
    begin = max(int(meets - before / SPACING), 0)
    end = min(int(met + after / SPACING), len(second) - 1)
    return splice(first[: begin + 1], second[end:])


def _nearest_pair(first: Floats, second: Floats) -> tuple[int, int]:
    """Indices of the points at which two evenly spaced lines are nearest to each other."""
    coarse = 8
    gaps = ((first[::coarse, None] - second[None, ::coarse]) ** 2).sum(-1)
    one, two = (int(i) * coarse for i in np.unravel_index(int(gaps.argmin()), gaps.shape))
    begin_one, begin_two = max(one - 2 * coarse, 0), max(two - 2 * coarse, 0)
    near = first[begin_one : one + 2 * coarse], second[begin_two : two + 2 * coarse]
    gaps = ((near[0][:, None] - near[1][None]) ** 2).sum(-1)
    one, two = (int(i) for i in np.unravel_index(int(gaps.argmin()), gaps.shape))
    return begin_one + one, begin_two + two


def splice(first: Floats, second: Floats) -> tuple[Floats, float, float]:
    """Join the end of one line to the beginning of another by a turn of continuous curvature.

    Returns:
        The joined poses, and the places on them where the turn begins and ends.
    """
    start, end = first[-1], second[0]
    full_turns = np.round((start[2] - end[2]) / (2 * np.pi))
    second = second + np.array([0.0, 0.0, 2 * np.pi * full_turns])
    turn = _quintic(start, second[0])
    whole = evenly(np.concatenate([turn, second[1:]]))
    begin = SPACING * (len(first) - 1)
    arc = float(np.hypot(*np.diff(turn[:, :2], axis=0).T).sum())
    return np.concatenate([first[:-1], whole]), begin, begin + arc


def _quintic(start: Floats, end: Floats) -> Floats:
    """A curve between two poses without curvature at its ends, shape (n, 3)."""
    chord = float(np.hypot(*(end - start)[:2]))
    # This speed keeps the curvature of a right-angled turn lowest.
    pull = 1.25 * chord / np.cos(0.25 * (end[2] - start[2])) ** 2
    share = np.linspace(0.0, 1.0, max(int(chord / 0.25), 8))[:, None]
    begin, finish = (pull * np.array([np.cos(p[2]), np.sin(p[2])]) for p in (start, end))
    jump = (end - start)[:2]
    third, fourth, fifth = (
        10 * jump - 6 * begin - 4 * finish,
        -15 * jump + 8 * begin + 7 * finish,
        6 * jump - 3 * begin - 3 * finish,
    )
    places = start[:2] + begin * share + third * share**3 + fourth * share**4 + fifth * share**5
    speed = begin + 3 * third * share**2 + 4 * fourth * share**3 + 5 * fifth * share**4
    heading = np.unwrap(np.arctan2(speed[:, 1], speed[:, 0]))
    heading += start[2] - heading[0]
    return np.concatenate([places, heading[:, None]], axis=-1)
