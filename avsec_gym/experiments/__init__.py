"""The thesis' tables and figures, chapter by chapter."""
