"""What sensors say of each other: disparity maps, and how they contradict each other."""
