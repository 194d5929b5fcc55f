"""Evidence that sensors give of each other: disparity maps, and where these contradict."""
