"""How the networks are trained: data, loop, checkpoints, curves."""
