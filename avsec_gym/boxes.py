"""`Boxes3D`: the one container for labels, detections and whatever an attacker makes of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats, camera_to_ego

_REQUIRED = {"location": (3,), "dimensions": (3,), "rotation_y": (), "score": ()}
_OPTIONAL = {"box2d": (4,), "truncation": (), "occlusion": (), "alpha": ()}


@dataclass(frozen=True, eq=False)
class Boxes3D:
    """N oriented boxes in KITTI's rectified camera frame (metres, radians).

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
        ConfigurationError: A shape does not fit, or a value is not finite.
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
        count = len(self.rotation_y)
        for name, tail in (_REQUIRED | _OPTIONAL).items():
            value = getattr(self, name)
            if value is None and name in _OPTIONAL:
                continue
            array = np.asarray(value, np.float64)
            if array.shape != (count, *tail):
                raise ConfigurationError(
                    f"Boxes3D.{name} has shape {array.shape}, expected {(count, *tail)}"
                )
            if not np.isfinite(array).all():
                raise ConfigurationError(f"Boxes3D.{name} holds a value that is not finite")
            object.__setattr__(self, name, array)
        for name, kind in (("category", np.str_), ("moving", np.bool_)):
            value = getattr(self, name)
            if value is None:
                continue
            array = np.asarray(value, kind)
            if array.shape != (count,):
                raise ConfigurationError(
                    f"Boxes3D.{name} has shape {array.shape}, expected {(count,)}"
                )
            object.__setattr__(self, name, array)

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
