"""What the car sees: stereo detectors, depth, moving objects, the road's type."""
