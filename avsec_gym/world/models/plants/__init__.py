"""Plants: trees, bushes, hedges, ivy, and the woods and hills far away."""

from avsec_gym.world.models.plants.backdrop import distant_woods, hills
from avsec_gym.world.models.plants.bushes import BUSHES, HEDGES, bush, hedge, ivy
from avsec_gym.world.models.plants.species import SPECIES, Detail
from avsec_gym.world.models.plants.trees import VARIANTS, tree

__all__ = [
    "BUSHES",
    "HEDGES",
    "SPECIES",
    "VARIANTS",
    "Detail",
    "bush",
    "distant_woods",
    "hedge",
    "hills",
    "ivy",
    "tree",
]
