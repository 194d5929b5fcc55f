"""How busy each style of place is: the numbers behind a population.

They are choices in KITTI's manner; per scene, each is scaled by chance, so that there are full
and empty streets.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from avsec_gym.world.layouts.dimensions import CategoryMix
from avsec_gym.world.site import Style


@dataclass(frozen=True)
class Bustle:
    """The contents of a usual scene of a style.

    Args:
        flow: Mean free metres between vehicles in a lane.
        pace: Share of the lane's usual speed that drivers want, at least and at most.
        parked: Share of a parking place's row that is occupied.
        edge_parking: Probability that cars park on the edge of a pavement where there are no
            parking places.
        turning: Share of the vehicles that turn into side streets.
        waiting: Mean number of vehicles that wait in a side street.
        walkers: Number of walkers for 100 m of each pavement.
        groups: Number of groups of standing people for 100 m of each pavement.
        crossing: Share of the walkers who cross the road.
        riders: Cyclists for 100 m of each lane or cycle path.
        mix: Categories of moving vehicles.
    """

    flow: float
    pace: tuple[float, float]
    parked: float = 0.0
    edge_parking: float = 0.0
    turning: float = 0.0
    waiting: float = 0.0
    walkers: float = 0.0
    groups: float = 0.0
    crossing: float = 0.0
    riders: float = 0.0
    mix: CategoryMix = field(default_factory=lambda: CategoryMix(Car=0.91, Van=0.07, Truck=0.02))


STYLES = {
    Style.CITY: Bustle(
        flow=45.0, pace=(0.75, 1.1), parked=0.75, edge_parking=0.15, turning=0.15, waiting=0.8,
        walkers=2.0, groups=0.4, crossing=0.2, riders=0.4,
    ),
    Style.RESIDENTIAL: Bustle(
        flow=110.0, pace=(0.8, 1.3), parked=0.7, edge_parking=0.5, turning=0.2, waiting=0.4,
        walkers=0.8, groups=0.2, crossing=0.2, riders=0.2,
        mix=CategoryMix(Car=0.92, Van=0.08),
    ),
    Style.CAMPUS: Bustle(
        flow=220.0, pace=(0.8, 1.2), parked=0.6, turning=0.15, waiting=0.2,
        walkers=4.0, groups=1.0, crossing=0.3, riders=1.3,
        mix=CategoryMix(Car=0.85, Van=0.15),
    ),
    Style.HIGHWAY: Bustle(
        flow=65.0, pace=(0.72, 1.0), mix=CategoryMix(Car=0.74, Truck=0.17, Van=0.09),
    ),
    Style.RURAL: Bustle(
        flow=130.0, pace=(0.6, 0.9), parked=0.3, turning=0.1, waiting=0.3, walkers=0.3,
        riders=0.15, mix=CategoryMix(Car=0.86, Van=0.08, Truck=0.06),
    ),
}  # fmt: skip
