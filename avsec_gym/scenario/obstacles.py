"""Obstacles as arrays, as kernels of planners take them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import keep_read_only, shown
from avsec_gym.errors import PlanningError
from avsec_gym.geometry import Floats
from avsec_gym.scenario.bounds import (
    ANGLE,
    COORDINATE,
    DURATION,
    SPEED,
    TIME_STEP,
    Bounds,
)
from avsec_gym.scenario.shapes import Rectangle, Shape, placed

_KINDS = {"iu": "whole numbers", "UO": "names", "fiu": "numbers", "b": "True and False"}


@dataclass(frozen=True, eq=False)
class Obstacles:
    """N obstacles as arrays, copied and read-only; a static one has one pose.

    What the planner believes is checked when it is made, and stays as it is: other obstacles are
    other `Obstacles`, as of `dataclasses.replace`.

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
        keep_read_only(self, vars(self) | {"shapes": tuple(self.shapes)})

    def __setstate__(self, state: dict[str, Any]) -> None:
        keep_read_only(self, state)

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
            poses: Poses at step 0, shape (N, 3); here and below, lists of numbers will do.
            length: Lengths, metres, shape (N,).
            width: Widths, metres, shape (N,).
            speed: Speeds, m/s, shape (N,); 0 stands.  None: all stand.
            dt: Length of a time step, seconds.
            last_step: Time step up to which moving ones are predicted.
            first_id: Ids count upwards from here.

        Raises:
            PlanningError: The arrays have different lengths, are none of numbers, or hold what no
                obstacle can have.
        """
        poses = _numbers("poses", poses, (3,))
        length, width = _numbers("lengths", length, ()), _numbers("widths", width, ())
        count = len(poses)
        speed = np.zeros(count) if speed is None else _numbers("speeds", speed, ())
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
        track = np.repeat(poses[:, None, :], horizon, axis=1)
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


def _numbers(name: str, values: Any, row: tuple[int, ...]) -> Floats:
    """What numpy takes for numbers, with rows of a shape."""
    try:
        array = np.asarray(values)
    except ValueError:  # Lists of several lengths.
        array = np.array(None)
    # A list of nothing has neither a kind nor rows.
    array = array.reshape(0, *row) if array.shape == (0,) else array
    if array.dtype.kind not in "iuf" or array.ndim == 0 or array.shape[1:] != row:
        expected = f"shape (N, {row[0]})" if row else "shape (N,)"
        raise PlanningError(
            f"{name} of obstacles are {shown(values)}; expected an array or list of numbers of"
            f" {expected}."
        )
    return array.astype(float)
