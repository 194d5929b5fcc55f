"""The thesis' chapter 5: what attacks on the detectors do to precision, and to driving safety."""
