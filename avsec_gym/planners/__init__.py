"""The motion planner M: motion primitives and best-first search (thesis, section 5.3.3)."""
