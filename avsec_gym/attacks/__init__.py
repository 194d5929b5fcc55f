"""What an attacker does to sensors, images or detections: one attack, one file."""

# The link of this name at the repository's root is for reading: imported by it, every class would
# be there twice.
if __name__ != "avsec_gym.attacks":
    raise ImportError(
        f"{__name__!r} is a link: import avsec_gym.attacks, the package, by its own name"
    )
