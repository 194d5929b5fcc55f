"""The motion planner M: motion primitives and best-first search (thesis, section 5.3.3)."""

# The link of this name at the repository's root is for reading: imported by it, every class would
# be there twice.
if __name__ != "avsec_gym.planners":
    raise ImportError(
        f"{__name__!r} is a link: import avsec_gym.planners, the package, by its own name"
    )
