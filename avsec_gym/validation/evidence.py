"""All that the sensors of a system say of each other at one moment, as one vector."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.disparity_error import DisparityErrors

Scope = tuple[int, ...]
"""Positions of the sensors that one element of the evidence depends on."""


def evidence_scopes(system: SensorSystem) -> tuple[Scope, ...]:
    """What the elements of the evidence depend on: three sensors for E_{i,j,k}, two for holes.

    Example:
        >>> evidence_scopes(SensorSystem(("lidar", 3, 2)))
        ((0, 1, 2), (1, 2))
    """
    return *system.triples, *_camera_pairs(system)


def gather_evidence(errors: DisparityErrors, threads: int = 2) -> Floats:
    """What one moment tells: E of every triple, and the hole share of every map of two cameras.

    Holes are counted in the whole image, beyond the scan's rows too, and once for each map, not
    for each triple that uses it.

    Args:
        errors: Of the moment; all its maps are found.
        threads: That find them.

    Returns:
        Shares in the order of `evidence_scopes`, shape (elements,).
    """
    maps = errors.maps
    system = maps.system
    maps.find(system.pairs(), threads)
    shares = [errors[triple].error for triple in system.triples]
    holes = [1.0 - float(maps[pair].valid.mean()) for pair in _camera_pairs(system)]
    return np.array([*shares, *holes])


def _camera_pairs(system: SensorSystem) -> tuple[tuple[int, int], ...]:
    return tuple((i, k) for i, k in system.pairs() if system.sensors[i] != LIDAR)
