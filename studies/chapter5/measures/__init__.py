"""Measures of perception, each of a single scene, that the study of telling measures compares."""
