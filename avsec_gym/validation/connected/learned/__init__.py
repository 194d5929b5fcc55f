"""The learned comparison (thesis, section 6.2): a small model on what rays and surfaces state."""
