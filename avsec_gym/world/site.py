"""A place without its traffic: road, side streets, land, and how it is built up."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from avsec_gym.road_type import RoadType
from avsec_gym.world.course import Course
from avsec_gym.world.ground import Ground
from avsec_gym.world.section import CrossSection, Surface

__all__ = ["Course", "CrossSection", "SideStreet", "Site", "Style", "Surface"]


class Style(StrEnum):
    """How a place is built up."""

    CITY = "city"
    RESIDENTIAL = "residential"
    CAMPUS = "campus"
    HIGHWAY = "highway"
    RURAL = "rural"


@dataclass(frozen=True, eq=False)
class SideStreet:
    """A street that ends at the main road.

    Args:
        along: Road coordinate of the main course where its middle line meets the main road, metres.
        side: Side of the main road: 1 to the left, -1 to the right.
        course: Leads away from the main road; its coordinate 0 lies on the main course's line.
        section: Cross section, right and left as a driver leaves the main road; carriageway only,
            with kerbs and pavements that begin behind those of the main road.
        radius: Radius of the rounded corners, metres.
    """

    along: float
    side: int
    course: Course
    section: CrossSection
    radius: float = 5.0


@dataclass(frozen=True, eq=False)
class Site:
    """A stretch of road and its surroundings; world frame: x, y on the ground, z up, metres.

    Args:
        style: Style in which the site is built up.
        course: The main road's line.
        section: The main road's cross-section.
        ground: The land's height.
        seed: Seed of everything that is drawn for this place (scenery, textures, paint, light).
        side_streets: Ends of other streets.
    """

    style: Style
    course: Course
    section: CrossSection
    ground: Ground
    seed: int
    side_streets: tuple[SideStreet, ...] = field(default=())

    @property
    def road_type(self) -> RoadType:
        """The road type that the driving-constraint selector should return."""
        return RoadType.HIGHWAY if self.style == Style.HIGHWAY else RoadType.STREET
