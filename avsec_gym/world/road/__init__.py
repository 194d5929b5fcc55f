"""Roads of the procedural world: course, cross-section, surfaces."""
