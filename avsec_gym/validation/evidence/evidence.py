"""All evidence that the sensors of a system give of each other in one frame, as one vector."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors

EVIDENCE_FORMAT = 4
"""Raised when something is measured otherwise; elements may go, and the others still hold."""
Scope = tuple[int, ...]
"""Positions of the sensors that one element of the evidence depends on."""


def evidence_elements(system: SensorSystem) -> tuple[tuple[str, Scope], ...]:
    """The elements of the evidence: what they measure, and of which sensors.

    Of every triple ``error``, and ``densest`` where it has a scan, see `DisparityError`; of every
    map of two cameras ``holes``, the share of the view that it does not know, and ``brighter`` and
    ``darker``, see `Brightness`.  Holes are counted in the whole image, beyond the scan's rows too,
    and once for each map, not for each triple that uses it.

    Example:
        >>> [scope for _, scope in evidence_elements(SensorSystem(("lidar", 3, 2)))]
        [(0, 1, 2), (0, 1, 2), (1, 2), (1, 2), (1, 2)]
    """
    pairs = tuple((i, k) for i, k in system.pairs() if system.sensors[i] != LIDAR)
    scopes = {
        "error": system.triples,
        "densest": tuple(triple for triple in system.triples if system.has_scan(triple)),
        "holes": pairs,
        "brighter": pairs,
        "darker": pairs,
    }
    return tuple((name, scope) for name, found in scopes.items() for scope in found)


def evidence_scopes(system: SensorSystem) -> tuple[Scope, ...]:
    """The sensors that each of the `evidence_elements` depends on."""
    return tuple(scope for _, scope in evidence_elements(system))


def gather_evidence(errors: DisparityErrors, threads: int = 2) -> Floats:
    """The evidence of one frame.

    Args:
        errors: The errors of the frame; all its maps are found.
        threads: The number of threads that find the maps.

    Returns:
        Shares in the order of `evidence_elements`, shape (elements,).
    """
    maps = errors.maps
    maps.find(maps.system.pairs(), threads)
    measure: dict[str, Callable[[Any], float]] = {
        "error": lambda triple: errors[triple].error,
        "densest": lambda triple: errors[triple].densest,
        "holes": lambda pair: 1.0 - float(maps[pair].valid.mean()),
        "brighter": lambda pair: maps.brightness(pair).brighter,
        "darker": lambda pair: maps.brightness(pair).darker,
    }
    return np.array([measure[name](scope) for name, scope in evidence_elements(maps.system)])
