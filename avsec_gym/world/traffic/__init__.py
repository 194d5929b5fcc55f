"""Traffic over time: the road users on a site, and their poses at every instant."""

from avsec_gym.world.traffic.populate import populate
from avsec_gym.world.traffic.population import Population
from avsec_gym.world.traffic.simulation import run, simulate, still

__all__ = ["Population", "populate", "run", "simulate", "still"]
