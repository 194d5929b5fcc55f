"""A straight street of one's own making, and traffic on drawn sites."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from avsec_gym.world.actors import Instant
from avsec_gym.world.course import course_from_curvature
from avsec_gym.world.ground import Ground
from avsec_gym.world.section import CrossSection, Lane, Strip, Surface
from avsec_gym.world.site import Site, Style
from avsec_gym.world.sites import draw_site
from avsec_gym.world.traffic import Population, populate, run

SECTION = CrossSection(
    (
        Strip(Surface.PAVEMENT, -7.0, -4.0, 0.12, "slabs"),
        Strip(Surface.KERB, -4.0, -3.86, 0.12),
        Strip(Surface.ROAD, -3.86, 5.25),
        Strip(Surface.KERB, 5.25, 5.39, 0.12),
        Strip(Surface.PAVEMENT, 5.39, 8.4, 0.12, "slabs"),
    ),
    (),
    (Lane(-1.75, 1, 13.9), Lane(1.75, -1, 13.9)),
)


class Run(NamedTuple):
    """Traffic on a site, and tracks of poses and speeds by actor, where it is there."""

    site: Site
    population: Population
    instants: list[Instant]
    poses: np.ndarray
    """Shape (T, N, 3), NaN where an actor is not there."""
    speeds: np.ndarray

    @property
    def moving(self) -> slice:
        return slice(0, len(self.population.travellers))


@pytest.fixture(scope="session")
def street() -> Site:
    return Site(
        Style.CITY, course_from_curvature(np.zeros(401), start=-100.0), SECTION, Ground(), seed=1
    )


@pytest.fixture(scope="session")
def watch() -> Callable[..., Run]:
    """Twenty seconds of traffic on a drawn site."""

    @cache
    def watched(style: Style, seed: int, egos: int = 1, duration: float = 20.0) -> Run:
        rng = np.random.default_rng(seed)
        site = draw_site(style, rng, length=700.0 if style == Style.HIGHWAY else 350.0)
        population = populate(site, rng, egos=egos)
        instants = run(site, population, duration)
        return Run(site, population, instants, *tracks(instants, len(population)))

    return watched


def tracks(instants: list[Instant], count: int) -> tuple[np.ndarray, np.ndarray]:
    poses = np.full((len(instants), count, 3), np.nan)
    speeds = np.full((len(instants), count), np.nan)
    for index, instant in enumerate(instants):
        poses[index, instant.actors.id] = instant.actors.pose
        speeds[index, instant.actors.id] = instant.actors.speed
    return poses, speeds
