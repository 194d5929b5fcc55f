"""A car's own evidence joined with that of connected vehicles, on rendered frames."""
