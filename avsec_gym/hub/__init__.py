"""Agents and detectors in the layout of the Hugging Face hub: written and read, never uploaded."""
