"""What attacks do to detectors, and what objects tell of them: sections 3.2.4 and 3.5."""
