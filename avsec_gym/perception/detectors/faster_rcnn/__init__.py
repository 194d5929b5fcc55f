"""Faster R-CNN (Ren et al., NeurIPS 2015) over a residual feature pyramid."""
