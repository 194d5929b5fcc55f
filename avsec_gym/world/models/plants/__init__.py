"""Plants: trees, bushes, hedges, ivy, grass, and the woods and hills far away."""

from avsec_gym.world.models.plants.species import SPECIES, Detail
from avsec_gym.world.models.plants.trees import VARIANTS, tree

__all__ = ["SPECIES", "VARIANTS", "Detail", "tree"]
