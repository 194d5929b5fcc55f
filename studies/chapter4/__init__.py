"""Evidence about connected vehicles."""
