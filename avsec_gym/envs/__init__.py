"""Gymnasium environments: one class, one short file; its docstring is its web page."""

# The link of this name at the repository's root is for reading: imported by it, every class would
# be there twice.
if __name__ != "avsec_gym.envs":
    raise ImportError(
        f"{__name__!r} is a link: import avsec_gym.envs, the package, by its own name"
    )
