"""What attacks do to detectors, and how mismatched objects reveal them: sections 3.2.4 and 3.5."""
