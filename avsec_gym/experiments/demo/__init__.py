"""The demo: both detectors in a few scenes in which it matters what a car sees."""
