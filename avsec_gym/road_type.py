"""The two kinds of road that the thesis distinguishes."""

from __future__ import annotations

from enum import StrEnum


class RoadType(StrEnum):
    """What the driving-constraint selector answers (thesis, section 5.3.1)."""

    STREET = "street"
    HIGHWAY = "highway"
