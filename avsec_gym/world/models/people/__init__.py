"""People on foot, on chairs and on bicycles."""

from avsec_gym.world.models.people.bicycle import make_bicycle
from avsec_gym.world.models.people.cyclist import make_cyclist
from avsec_gym.world.models.people.gait import METRES_PER_CRANK, stride_length
from avsec_gym.world.models.people.person import make_person

__all__ = ["METRES_PER_CRANK", "make_bicycle", "make_cyclist", "make_person", "stride_length"]
