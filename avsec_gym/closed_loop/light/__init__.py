"""Drives without highway-env's objects: tables, arrays and kernels, equal to it step for step."""
