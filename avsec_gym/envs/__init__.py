"""Gymnasium environments: one class, one short file; its docstring is its web page."""
