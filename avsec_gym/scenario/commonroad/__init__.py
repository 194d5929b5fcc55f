"""Planning scenarios to and from CommonRoad XML, by way of commonroad-io.

What `write_commonroad` writes, `read_commonroad` reads back bit for bit.  Road type, intention and
the scenario's own id have no place in the format; they travel in its ``source`` attribute.
"""

from avsec_gym.scenario.commonroad.reading import read_commonroad
from avsec_gym.scenario.commonroad.writing import to_commonroad, write_commonroad

__all__ = ["read_commonroad", "to_commonroad", "write_commonroad"]
