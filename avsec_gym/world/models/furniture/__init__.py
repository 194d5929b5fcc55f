"""Street furniture: lamps, signs, lights, barriers, and all that stands on pavements.

`catalogue` has everything that stands on one spot, by name; `barriers` and `fences` follow a path;
`crossings` spans a road.  The origin is at the foot, and the front is at -x: placed with the road's
heading, a thing faces oncoming traffic.
"""
