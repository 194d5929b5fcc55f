"""The demo: both detectors in a dozen scenes in which it matters what a car sees."""
