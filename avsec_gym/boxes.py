"""`Boxes3D`: the one container for labels, detections and whatever an attacker makes of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import keep_read_only, read_only, shown
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, camera_to_ego

_REQUIRED = {"location": (3,), "dimensions": (3,), "rotation_y": (), "score": ()}
_OPTIONAL = {"box2d": (4,), "truncation": (), "occlusion": (), "alpha": ()}
_ANGLES = {"rotation_y", "alpha"}
_KINDS: dict[type[np.generic], str] = {
    np.float64: "numbers",
    np.str_: "names",
    np.bool_: "True and False",
}

LARGEST_ANGLE = 100.0
"""Radians.  Sources of boxes give angles in [-pi, pi], or with some turns too many."""


@dataclass(frozen=True, eq=False)
class Boxes3D:
    """N oriented boxes in KITTI's rectified camera frame (metres, radians).

    The arrays are copies of what is given, and read-only: what was checked stays what it is.

    Args:
        location: Bottom centres, shape (N, 3).
        dimensions: Height, width, length, shape (N, 3).
        rotation_y: Yaw about the camera's y axis, shape (N,).
        score: Confidence, higher is surer, shape (N,); 1 for ground truth.
        category: Names such as ``Car``, shape (N,).
        box2d: Left, top, right, bottom in pixels, shape (N, 4).
        truncation: Share outside the image in [0, 1], shape (N,); -1 where unknown.
        occlusion: KITTI's level 0..3, shape (N,); -1 where unknown.
        alpha: Observation angle, shape (N,); -10 where unknown.
        moving: Whether each object moves, shape (N,).

    Raises:
        ConfigurationError: A shape does not fit, a value is no number or not finite, or an angle
            has more turns than any source of boxes gives.
    """

    location: Floats
    dimensions: Floats
    rotation_y: Floats
    score: Floats
    category: NDArray[np.str_]
    box2d: Floats | None = None
    truncation: Floats | None = None
    occlusion: Floats | None = None
    alpha: Floats | None = None
    moving: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        angles = _column("rotation_y", self.rotation_y, np.float64)
        count = len(angles) if angles.ndim else 0
        for name, tail in (_REQUIRED | _OPTIONAL).items():
            value = getattr(self, name)
            if value is None and name in _OPTIONAL:
                continue
            array = _column(name, value, np.float64)
            if array.shape != (count, *tail):
                raise ConfigurationError(
                    f"Boxes3D.{name} has shape {array.shape}, expected {(count, *tail)}"
                )
            if not np.isfinite(array).all():
                raise ConfigurationError(f"Boxes3D.{name} holds a value that is not finite")
            if name in _ANGLES and (np.abs(array) > LARGEST_ANGLE).any():
                raise ConfigurationError(
                    f"Boxes3D.{name} holds an angle of {np.abs(array).max():g} rad;"
                    f" {LARGEST_ANGLE:g} rad is the most: beyond, sine and cosine lose digits, and"
                    " a unit was mistaken. Give radians from -pi to pi."
                )
            object.__setattr__(self, name, read_only(array))
        for name, kind in (("category", np.str_), ("moving", np.bool_)):
            value = getattr(self, name)
            if value is None:
                continue
            array = _column(name, value, kind)
            if array.shape != (count,):
                raise ConfigurationError(
                    f"Boxes3D.{name} has shape {array.shape}, expected {(count,)}"
                )
            object.__setattr__(self, name, read_only(array))

    def __setstate__(self, state: dict[str, Any]) -> None:
        keep_read_only(self, state)

    @classmethod
    def empty(cls) -> Boxes3D:
        """No boxes at all."""
        return cls(
            np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0), np.zeros(0, np.str_)
        )

    def __len__(self) -> int:
        return len(self.rotation_y)

    def __getitem__(self, index: Any) -> Boxes3D:
        """The boxes picked by a mask, a slice or an integer array."""
        picked: dict[str, Any] = {}
        for field in fields(self):
            value = getattr(self, field.name)
            picked[field.name] = None if value is None else value[index]
        return Boxes3D(**picked)

    @classmethod
    def concatenate(cls, parts: Iterable[Boxes3D]) -> Boxes3D:
        """All boxes in order; an optional field survives where every part has it."""
        parts = list(parts)
        if not parts:
            return cls.empty()
        columns: dict[str, Any] = {}
        for field in fields(cls):
            values = [getattr(part, field.name) for part in parts]
            known = all(value is not None for value in values)
            columns[field.name] = np.concatenate(values) if known else None
        return cls(**columns)

    @property
    def poses(self) -> Floats:
        """Ground-plane poses (x, y, heading) in the ego frame, shape (N, 3)."""
        return camera_to_ego(self.location, self.rotation_y)

    @property
    def length(self) -> Floats:
        """Extent along the heading, shape (N,)."""
        return self.dimensions[:, 2]

    @property
    def width(self) -> Floats:
        """Extent across the heading, shape (N,)."""
        return self.dimensions[:, 1]


def _column(name: str, values: Any, kind: type[np.generic]) -> NDArray[Any]:
    """A copy of a column that was given, of a kind."""
    try:
        return np.array(values, kind)
    except (TypeError, ValueError) as error:
        raise ConfigurationError(
            f"Boxes3D.{name} is no array of {_KINDS[kind]}: {shown(values)}"
        ) from error
