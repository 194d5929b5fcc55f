"""The renderer: page, text and JSON of the sections that experiments show of a run."""
