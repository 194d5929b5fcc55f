"""Evidence of the main job."""
