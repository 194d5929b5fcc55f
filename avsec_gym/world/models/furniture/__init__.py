"""Street furniture: lamps, signs, lights, barriers, and all that stands on pavements.

Everything has its origin at its foot and faces -x: placed with the road's heading, it faces
oncoming traffic.
"""
