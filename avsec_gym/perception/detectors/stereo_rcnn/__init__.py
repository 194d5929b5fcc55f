"""Stereo R-CNN (Li, Chen and Shen, CVPR 2019)."""
