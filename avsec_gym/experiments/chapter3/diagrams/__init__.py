"""Chapter 3's figures over the parameters that the thesis leaves open, as diagrams."""
