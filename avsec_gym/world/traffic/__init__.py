"""Traffic over time: who is on a site, and where everybody is moment by moment."""

from avsec_gym.world.traffic.populate import populate
from avsec_gym.world.traffic.population import Population
from avsec_gym.world.traffic.simulation import run, simulate, still

__all__ = ["Population", "populate", "run", "simulate", "still"]
