"""Traffic over time: the poses and speeds of all actors, instant by instant."""

from __future__ import annotations

import numpy as np

from avsec_gym.geometry import Floats
from avsec_gym.world.actors import Actors, Instant
from avsec_gym.world.models.people import METRES_PER_CRANK, stride_length
from avsec_gym.world.site import Site
from avsec_gym.world.traffic.ahead import interactions_ahead
from avsec_gym.world.traffic.driving import RESPONSE, idm_acceleration, slow_down
from avsec_gym.world.traffic.egos import EGO_SPACING
from avsec_gym.world.traffic.gates import (
    Zones,
    find_zones,
    interactions_with_gates,
    pass_gates,
)
from avsec_gym.world.traffic.overtaking import change_lanes
from avsec_gym.world.traffic.populate import populate
from avsec_gym.world.traffic.population import Bystander, Population, Traveller
from avsec_gym.world.traffic.routes import SPACING
from avsec_gym.world.traffic.state import (
    Network,
    Traffic,
    begin,
    network_of,
    on_route,
    place_all,
)
from avsec_gym.world.traffic.surface import surface_height

LONGEST_TICK = 0.1
"""Longest tick of the simulation, seconds."""
SIGHT = 100.0
"""Metres from every ego vehicle within which no actor appears or vanishes at the site's ends."""
MOVING = 0.3
"""m/s above which an actor moves."""


def simulate(
    site: Site,
    rng: np.random.Generator,
    *,
    duration: float,
    step: float = 0.1,
    egos: int = 1,
    density: float | None = None,
    spacing: tuple[float, float] = EGO_SPACING,
) -> list[Instant]:
    """Traffic on a site.

    Args:
        site: The place.
        rng: The source of chance; the same state gives the same traffic.
        duration: Time that is simulated, seconds; a shorter run has the same first instants as a
            longer one.
        step: Time between instants, seconds.
        egos: Number of vehicles that carry sensors.
        density: Amount of traffic, see `populate`.
        spacing: Distances between sensor vehicles, see `populate`.

    Returns:
        Instants at 0, step, 2 step ... up to the duration. Ids stay the same; an actor that
        has left the site is no longer listed, unless an ego vehicle is within `SIGHT`. The
        ego vehicles are the first actors and always there. An actor moves if it is faster than
        `MOVING`.
    """
    return run(
        site, populate(site, rng, egos=egos, density=density, spacing=spacing), duration, step
    )


def still(site: Site, rng: np.random.Generator, egos: int = 1) -> Instant:
    """One instant of the traffic on a site, as several connected vehicles may see it."""
    return simulate(site, rng, duration=0.0, egos=egos)[0]


def run(site: Site, population: Population, duration: float, step: float = 0.1) -> list[Instant]:
    """Let a population go; see `simulate`."""
    network = network_of(population.routes)
    zones = find_zones(network)
    traffic = begin(network, population.travellers)
    pauses = np.array([traveller.pause for traveller in population.travellers]).reshape(-1, 2)
    ticks = max(1, int(np.ceil(step / LONGEST_TICK - 1e-9)))
    count = int(duration / step + 1e-9) + 1
    travelled = np.zeros(len(traffic.place))
    history = []
    for instant in range(count):
        shown = _shown(network, traffic, population)
        history.append((traffic.poses.copy(), traffic.speed.copy(), travelled.copy(), shown))
        for tick in range(ticks):
            time = step * (instant + tick / ticks)
            travelled += _advance(network, zones, population, traffic, pauses, time, step / ticks)
    return _instants(site, population, history, step)


def _advance(
    network: Network,
    zones: Zones,
    population: Population,
    traffic: Traffic,
    pauses: Floats,
    time: float,
    tick: float,
) -> Floats:
    """One tick: decide, accelerate, move. Returns the metres travelled."""
    # Decide: another lane, once a second, and whether to pass a gate.
    if (population.neighbours >= 0).any() and (time + 1e-9) % 1.0 < tick:
        change_lanes(network, population.neighbours, traffic)
    pass_gates(network, zones, traffic, time)
    # Accelerate: by the IDM against all that is ahead, then for bends, then for pauses.
    felt = np.maximum(
        interactions_ahead(network, traffic), interactions_with_gates(network, zones, traffic)
    )
    wanted = idm_acceleration(traffic.speed, traffic.desired, felt, traffic.manners)
    _, here = on_route(network, traffic.route, traffic.place)
    _, ahead = on_route(network, traffic.route, traffic.place + RESPONSE * traffic.speed)
    limit = np.minimum(network.limit[here], network.limit[ahead])
    wanted = slow_down(traffic.speed, limit, wanted)
    pausing = (pauses[:, 0] <= time) & (time < pauses[:, 1])
    wanted = np.where(pausing, np.minimum(wanted, -0.7 * traffic.manners.braking), wanted)
    wanted = np.where((traffic.speed < 0.1) & (wanted < 0.1), -np.inf, wanted)
    # Move by the mean speed of the tick; `place` runs on the route, the way on the shifted line.
    after = np.maximum(traffic.speed + wanted * tick, 0.0)
    way = 0.5 * (traffic.speed + after) * tick
    traffic.speed[:] = after
    traffic.place[:] += way * place_all(network, traffic)[1]
    traffic.poses[:] = place_all(network, traffic)[0]
    return way


def _shown(network: Network, traffic: Traffic, population: Population) -> np.ndarray:
    """Whether each traveller is within the site, or near enough to an ego vehicle, shape (N,)."""
    limits = network.shown[traffic.route]
    inside = (limits[:, 0] <= traffic.place) & (traffic.place <= limits[:, 1])
    standing = [bystander.pose[:2] for bystander in population.bystanders]
    places = np.concatenate([traffic.poses[:, :2], np.reshape(standing, (-1, 2))])
    apart = traffic.poses[:, None, :2] - places[None, list(population.egos)]
    near = (np.hypot(apart[..., 0], apart[..., 1]) < SIGHT).any(axis=1)
    ends = SPACING * (np.diff(network.first) - 1)[traffic.route]
    return (inside | near) & (traffic.place >= 0.0) & (traffic.place <= ends)


def _instants(
    site: Site,
    population: Population,
    history: list[tuple[Floats, Floats, Floats, np.ndarray]],
    step: float,
) -> list[Instant]:
    standing = np.reshape([bystander.pose for bystander in population.bystanders], (-1, 3))
    everything: list[Traveller | Bystander] = [*population.travellers, *population.bystanders]
    category = np.array([actor.category for actor in everything])
    dimensions = np.array([actor.dimensions for actor in everything])
    moving_poses = np.stack([poses for poses, *_ in history])
    heights = _heights(site, moving_poses, category[: len(population.travellers)])
    standing_heights = surface_height(site, standing[:, 0], standing[:, 1])
    turn = np.where(category == "Pedestrian", stride_length(dimensions[:, 0]), METRES_PER_CRANK)
    steps = np.isin(category, ["Pedestrian", "Cyclist"])
    still = np.zeros(len(standing))
    # The ego vehicles come first.
    order = np.array(
        [*population.egos, *(i for i in range(len(everything)) if i not in population.egos)]
    )
    instants = []
    for index, (poses, speed, travelled, shown) in enumerate(history):
        speeds = np.concatenate([speed, still])
        way = np.concatenate([travelled, still])
        actors = Actors(
            id=np.arange(len(everything)),
            category=category,
            dimensions=dimensions,
            pose=np.concatenate([poses, standing]),
            z=np.concatenate([heights[index], standing_heights]),
            speed=speeds,
            moving=np.abs(speeds) > MOVING,
            appearance=population.appearance,
            phase=np.where(steps, (population.phase + way / turn) % 1.0, 0.0),
        )
        here = np.concatenate([shown, np.ones(len(standing), bool)])
        here[list(population.egos)] = True
        chosen = actors.pick(order[here[order]])
        instants.append(Instant(index * step, chosen, tuple(range(len(population.egos)))))
    return instants


def _heights(site: Site, poses: Floats, category: np.ndarray) -> Floats:
    """Heights under travellers at all instants, shape (T, N)."""
    heights = site.ground.height(poses[..., 0], poses[..., 1])
    # Vehicles keep to the carriageways, which lie on the ground.
    afoot = np.isin(category, ["Pedestrian", "Cyclist"])
    heights[:, afoot] = surface_height(site, poses[:, afoot, 0], poses[:, afoot, 1])
    return heights
