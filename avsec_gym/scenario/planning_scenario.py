"""`PlanningScenario`: the input of a motion planner (thesis, section 5.3.1).

A scenario is written in one plane frame (metres, radians, x forward and y left of the ego vehicle
where it was built from a KITTI frame) and in time steps of ``dt`` seconds.  Numbers that no problem
can have, such as a position that is not finite, are a `PlanningError` as soon as an object is made
of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from avsec_gym.argument_checks import shown
from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.bounds import (
    ANGLE,
    COORDINATE,
    DURATION,
    SPEED,
    TIME_STEP,
    Bounds,
)
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.shapes import Rectangle, Shape, placed

_GAP = 0.01
"""Metres; narrower gaps between lanelets are drawing errors."""
_SLIT = 3e-10
"""Metres: narrower gaps between the sections of a road are no gaps."""


@dataclass(frozen=True)
class EgoState:
    """The ego vehicle's state s = (p, v, phi, omega) at the start; the position is its centre."""

    x: float = 0.0
    y: float = 0.0
    velocity: float = 0.0
    heading: float = 0.0
    steering_angle: float = 0.0
    step: int = 0

    def __post_init__(self) -> None:
        COORDINATE.check(self.x, "the start's x")
        COORDINATE.check(self.y, "the start's y")
        SPEED.check(self.velocity, "the start's velocity")
        ANGLE.check(self.heading, "the start's heading")
        ANGLE.check(self.steering_angle, "the start's steering angle")
        TIME_STEP.check(self.step, "the start's time step")


@dataclass(frozen=True)
class Goal:
    """A goal region: the vehicle's centre within a region, its state within intervals."""

    steps: tuple[int, int]
    """First and last time step."""
    region: tuple[Shape, ...] | None = None
    """The centre lies in one of these; None: anywhere."""
    heading: tuple[float, float] | None = None
    velocity: tuple[float, float] | None = None
    lanelets: tuple[int, ...] = ()
    """The lanelets that the region stands for, where a file gave it that way."""

    def __post_init__(self) -> None:
        for interval, bounds, what in (
            (self.steps, TIME_STEP, "time window"),
            (self.heading, ANGLE, "heading interval"),
            (self.velocity, SPEED, "velocity interval"),
        ):
            if interval is not None:
                _check_interval(interval, bounds, what)
        if self.region is not None and not _are(Shape, self.region):
            raise PlanningError(
                f"a goal's region is {shown(self.region)}; expected a tuple of shapes, or None for"
                " anywhere."
            )


def _are(kind: Any, values: Any) -> bool:
    """Whether this is a tuple of one or more of a kind."""
    return isinstance(values, tuple) and bool(values) and all(isinstance(v, kind) for v in values)


def _check_interval(interval: tuple[float, float], bounds: Bounds, what: str) -> None:
    bounds.check_all(interval, f"an end of a goal's {what}")
    if len(interval) != 2:
        raise PlanningError(f"a goal's {what} is {shown(interval)}; expected two numbers.")
    if interval[0] > interval[1]:
        raise PlanningError(f"a goal's {what} {interval} ends before it begins.")


@dataclass(frozen=True)
class Lanelet:
    """A piece of lane between two bounds, in driving direction."""

    id: int
    left: tuple[tuple[float, float], ...]
    right: tuple[tuple[float, float], ...]
    predecessors: tuple[int, ...] = ()
    successors: tuple[int, ...] = ()
    adjacent_left: tuple[int, bool] | None = None
    """Id of the neighbour and whether it runs in the same direction."""
    adjacent_right: tuple[int, bool] | None = None
    types: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        COORDINATE.check_all(self.left, f"a point of the left bound of lanelet {self.id}")
        COORDINATE.check_all(self.right, f"a point of the right bound of lanelet {self.id}")
        for bound in (self.left, self.right):
            if len(bound) < 2 or any(len(point) != 2 for point in bound):
                raise PlanningError(
                    f"a bound of lanelet {self.id} is {shown(bound)}; expected two points (x, y)"
                    " or more."
                )

    def polygon(self) -> shapely.Polygon:
        """The lanelet's area."""
        return shapely.Polygon([*self.left, *reversed(self.right)])


@dataclass(frozen=True)
class Road:
    """The lanelets; without any, the ground is free everywhere."""

    lanelets: tuple[Lanelet, ...] = ()

    @cached_property
    def area(self) -> shapely.Geometry:
        """Union of the road's sections, exactly as given: gaps between them stay gaps.

        A section is a lanelet with its neighbours; as in commonroad-drivability-checker only its
        outer bounds count, so that bounds between neighbours may be sampled differently.
        """
        sections = shapely.make_valid(np.array(_sections(self.lanelets), object))
        area = shapely.union_all(sections)
        if self.lanelets and not area.area > 0:
            raise PlanningError("the road has no area; correct the bounds of its lanelets.")
        if len(sections) == 1:
            return area
        # Close the slits that only rounding made.
        return area.buffer(_SLIT / 2, join_style="mitre").buffer(-_SLIT / 2, join_style="mitre")

    @cached_property
    def edges(self) -> Floats:
        """The road edge as segments x1, y1, x2, y2, shape (M, 4), collinear ones merged."""
        return _segments(self.area) if self.lanelets else np.zeros((0, 4))

    @cached_property
    def closed_edges(self) -> Floats:
        """`edges` after gaps between lanelets of up to a centimetre are closed."""
        if not self.lanelets:
            return np.zeros((0, 4))
        closed = self.area.buffer(_GAP / 2, join_style="mitre")
        closed = closed.buffer(-_GAP / 2, join_style="mitre")
        # Where nothing was closed, the exact edge is kept, free of rounding.
        same = abs(closed.area - self.area.area) < 1e-6 and _rings(closed) == _rings(self.area)
        return self.edges if same else _segments(closed)

    @cached_property
    def centre_segments(self) -> tuple[Floats, Floats]:
        """Starts and ends of the lanelets' centre lines, each of shape (S, 2)."""
        lines = [0.5 * (left + right) for left, right in map(_paired, self.lanelets)]
        if not lines:
            return np.zeros((0, 2)), np.zeros((0, 2))
        return np.vstack([line[:-1] for line in lines]), np.vstack([line[1:] for line in lines])


def _paired(lanelet: Lanelet) -> tuple[Floats, Floats]:
    """Both bounds with as many points; the sparser one is walked at the pace of the other."""
    left, right = np.array(lanelet.left, float), np.array(lanelet.right, float)
    if len(left) < len(right):
        left = _at_the_pace_of(right, left)
    elif len(right) < len(left):
        right = _at_the_pace_of(left, right)
    return left, right


def _at_the_pace_of(dense: Floats, sparse: Floats) -> Floats:
    """Points of a line at the shares of its length at which another line has its points."""
    come = [np.r_[0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T))] for line in (dense, sparse)]
    at = come[0] / max(come[0][-1], 1e-12) * come[1][-1]
    return np.column_stack([np.interp(at, come[1], sparse[:, axis]) for axis in (0, 1)])


def _segments(area: shapely.Geometry) -> Floats:
    """The boundary of an area, shape (M, 4)."""
    boundary = shapely.boundary(shapely.simplify(area, 0.0))
    segments = []
    for line in shapely.get_parts(shapely.line_merge(boundary)):
        points = np.array(line.coords)
        segments.append(np.hstack([points[:-1], points[1:]]))
    return np.vstack(segments)


def _rings(area: shapely.Geometry) -> int:
    """Number of closed lines that bound an area."""
    return sum(1 + shapely.get_num_interior_rings(part) for part in shapely.get_parts(area))


def _sections(lanelets: tuple[Lanelet, ...]) -> list[shapely.Polygon]:
    """Areas of lanelets side by side, each from its rightmost to its leftmost bound."""
    known = {lanelet.id: lanelet for lanelet in lanelets}
    covered: set[int] = set()
    areas = []

    def walk(lanelet: Lanelet, forward: bool, to_the_left: bool) -> list[tuple[Lanelet, bool]]:
        """The lanelet and its neighbours on one side; forward: runs in the walk's direction."""
        row = [(lanelet, forward)]
        while True:
            neighbour = lanelet.adjacent_left if forward == to_the_left else lanelet.adjacent_right
            if neighbour is None or neighbour[0] not in known or len(row) > len(known):
                return row
            lanelet, forward = known[neighbour[0]], forward == neighbour[1]
            row.append((lanelet, forward))

    for lanelet in lanelets:
        if lanelet.id in covered:
            continue
        rightmost, forward = walk(lanelet, True, to_the_left=False)[-1]
        row = walk(rightmost, forward, to_the_left=True)
        covered.update(member.id for member, _ in row)
        bounds = [
            (member.right, member.left) if forward else (member.left[::-1], member.right[::-1])
            for member, forward in row
        ]
        starts = [point for right, left in bounds for point in (right[0], left[0])]
        ends = [point for right, left in reversed(bounds) for point in (left[-1], right[-1])]
        leftmost, rightmost_bound = bounds[-1][1], bounds[0][0]
        areas.append(shapely.Polygon([*starts, *leftmost[1:-1], *ends, *rightmost_bound[-2:0:-1]]))
    return areas


_KINDS = {"iu": "whole numbers", "UO": "names", "fiu": "numbers", "b": "True and False"}


@dataclass(frozen=True)
class Obstacles:
    """N obstacles as arrays; a static one has one pose.

    Args:
        ids: Unique ids, shape (N,).
        categories: CommonRoad obstacle types such as ``car`` and ``parkedVehicle``, shape (N,).
        shapes: N shapes, each in the obstacle's own frame.
        poses: Poses x, y, heading, shape (N, T, 3); row i is valid up to ``steps[i]`` and repeats
            its last pose after.
        speeds: Speeds along the heading, m/s, shape (N, T).
        steps: Number of known states, shape (N,); 1 with ``static`` set where it never moves.
        first_step: Time step of the first state, shape (N,).
        static: Whether each stands for good, shape (N,).
    """

    ids: NDArray[np.int64]
    categories: NDArray[np.str_]
    shapes: tuple[Shape, ...]
    poses: Floats
    speeds: Floats
    steps: NDArray[np.int64]
    first_step: NDArray[np.int64]
    static: NDArray[np.bool_]

    def __post_init__(self) -> None:
        self._check_layout()
        COORDINATE.check_all(self.poses[..., :2], "a position of an obstacle")
        ANGLE.check_all(self.poses[..., 2], "a heading of an obstacle")
        SPEED.check_all(self.speeds, "a speed of an obstacle")
        TIME_STEP.check_all(self.first_step, "the first time step of an obstacle")
        known = Bounds(1, self.poses.shape[1], whole=True)
        known.check_all(self.steps, "the number of known states of an obstacle")

    def _check_layout(self) -> None:
        """Refuse arrays that do not belong together: the kernels trust them."""
        if not all(isinstance(shape, Shape) for shape in self.shapes):
            raise PlanningError(f"the shapes of obstacles are {shown(self.shapes)}.")
        count, known = len(self.shapes), max(1, *np.shape(self.poses)[1:2])
        for name, (kinds, shape) in {
            "ids": ("iu", (count,)),
            "categories": ("UO", (count,)),
            "poses": ("fiu", (count, known, 3)),
            "speeds": ("fiu", (count, known)),
            "steps": ("iu", (count,)),
            "first_step": ("iu", (count,)),
            "static": ("b", (count,)),
        }.items():
            array = getattr(self, name)
            if (
                not isinstance(array, np.ndarray)
                or array.shape != shape
                or array.dtype.kind not in kinds
            ):
                raise PlanningError(
                    f"{name} of {count} obstacles is {shown(array)}; expected an array of shape"
                    f" {shape} with {_KINDS[kinds]}."
                )

    def __len__(self) -> int:
        return len(self.shapes)

    @classmethod
    def rectangles(
        cls,
        poses: Floats,
        length: Floats,
        width: Floats,
        speed: Floats | None = None,
        *,
        dt: float = 0.1,
        last_step: int = 0,
        first_id: int = 1000,
    ) -> Obstacles:
        """Rectangles that stand, or drive at constant velocity along their heading.

        Args:
            poses: Poses at step 0, shape (N, 3).
            length: Lengths, metres, shape (N,).
            width: Widths, metres, shape (N,).
            speed: Speeds, m/s, shape (N,); 0 stands.  None: all stand.
            dt: Length of a time step, seconds.
            last_step: Time step up to which moving ones are predicted.
            first_id: Ids count upwards from here.

        Raises:
            PlanningError: The arrays have different lengths, or hold what no obstacle can have.
        """
        count = len(poses)
        speed = np.zeros(count) if speed is None else np.asarray(speed, float)
        TIME_STEP.check(last_step, "the last time step of obstacles")
        DURATION.check(dt, "the duration of a time step")
        if not len(length) == len(width) == len(speed) == count:
            raise PlanningError(
                f"{count} poses of obstacles come with {len(length)} lengths, {len(width)} widths"
                f" and {len(speed)} speeds; expected as many of each."
            )
        static = speed == 0
        horizon = 1 if static.all() else last_step + 1
        travelled = speed[:, None] * dt * np.arange(horizon)
        track = np.repeat(np.asarray(poses, float)[:, None, :], horizon, axis=1)
        track[..., 0] += travelled * np.cos(track[..., 2])
        track[..., 1] += travelled * np.sin(track[..., 2])
        return cls(
            ids=first_id + np.arange(count),
            categories=np.where(static, "parkedVehicle", "car"),
            shapes=tuple(
                Rectangle(a, b) for a, b in zip(length.tolist(), width.tolist(), strict=True)
            ),
            poses=track,
            speeds=np.repeat(speed[:, None], horizon, axis=1),
            steps=np.where(static, 1, horizon),
            first_step=np.zeros(count, np.int64),
            static=static,
        )

    @classmethod
    def none(cls) -> Obstacles:
        """An empty road."""
        return cls.rectangles(np.zeros((0, 3)), np.zeros(0), np.zeros(0))

    def pose_index(self, step: int) -> NDArray[np.int64]:
        """Row of `poses` that holds at a time step; -1 before an obstacle appears.

        The last known state is kept for ever, as commonroad-search keeps it.
        """
        index = np.minimum(step - self.first_step, self.steps - 1)
        return np.where(self.static, 0, np.where(index < 0, -1, index))

    def polygons(self, step: int) -> NDArray[np.object_]:
        """Occupied areas at a time step as shapely geometries, shape (N,); None where absent."""
        index = self.pose_index(step)
        areas = np.empty(len(self), object)
        for i, shape in enumerate(self.shapes):
            if index[i] >= 0:
                areas[i] = placed(shape, self.poses[i, index[i]])
        return areas


@dataclass(frozen=True)
class PlanningScenario:
    """A planning problem: start, goals, road and obstacles."""

    id: str
    start: EgoState
    goals: tuple[Goal, ...]
    road: Road = field(default_factory=Road)
    obstacles: Obstacles = field(default_factory=Obstacles.none)
    dt: float = 0.1
    road_type: RoadType | None = None
    intention: Intention | None = None

    def __post_init__(self) -> None:
        DURATION.check(self.dt, f"{self.id}: the duration of a time step")
        if self.goals and not _are(Goal, self.goals):
            raise PlanningError(f"{self.id}: goals are a tuple of Goal, got {shown(self.goals)}.")

    def with_obstacles(self, obstacles: Obstacles) -> PlanningScenario:
        """The same problem among other obstacles."""
        return replace(self, obstacles=obstacles)

    @property
    def last_step(self) -> int:
        """The latest time step that any goal accepts."""
        return max(goal.steps[1] for goal in self.goals)


def straight_lanes(
    count: int, width: float = 3.5, start: float = -10.0, end: float = 130.0
) -> tuple[Lanelet, ...]:
    """Parallel straight lanes along x, centred on y = 0, numbered from right to left.

    Args:
        count: Number of lanes; odd, so that one is centred on the ego vehicle.
        width: Width of a lane, metres.
        start: Coordinate x at which the lanes begin, metres.
        end: Coordinate x at which they end, metres.
    """
    offsets: Sequence[float] = [(i - count / 2) * width for i in range(count + 1)]
    return tuple(
        Lanelet(
            id=i + 1,
            left=((start, offsets[i + 1]), (end, offsets[i + 1])),
            right=((start, offsets[i]), (end, offsets[i])),
            adjacent_left=(i + 2, True) if i + 1 < count else None,
            adjacent_right=(i, True) if i > 0 else None,
            types=("urban",),
        )
        for i in range(count)
    )
