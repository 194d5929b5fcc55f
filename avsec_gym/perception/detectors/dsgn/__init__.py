"""DSGN: a stereo detector whose volume of depths becomes a bird's-eye view (Chen et al., 2020)."""
