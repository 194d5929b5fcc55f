"""`Alignment`: how dense alignment searches the depth of a box."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class Alignment:
    """How the depth is searched; the defaults are the published numbers.

    Args:
        coarse_steps: The number of steps of `coarse_interval` metres, about the depth that the
            solver found.
        coarse_interval: The distance of coarse steps, metres.
        fine_steps: The number of steps of `fine_interval` metres, about the best of them.
        fine_interval: The distance of fine steps, metres.
        nearest: No depth below this is tried at first, metres.
        most_pixels: A box is thinned out to less than twice so many rows and columns.
        most_difference: A larger difference of a pixel's colour counts as this much, grey levels;
            None: all count in full.  What mirrors or is hidden in one view differs at any depth.
        parabola: Whether the best fine step is refined by a parabola through it and its neighbours.
        disparity_offset: The number of pixels that is added to the disparity in the end.
        side_inset: How far a car's flanks lie inside of its box, metres.
        front_inset: How far its front does.
        rear_inset: How far its rear does.

    Raises:
        ConfigurationError: A search without steps.
    """

    coarse_steps: int = 50
    coarse_interval: float = 0.5
    fine_steps: int = 20
    fine_interval: float = 0.05
    nearest: float = 1.5
    most_pixels: int = 56
    most_difference: float | None = None
    parabola: bool = False
    disparity_offset: float = 0.5
    side_inset: float = 0.0
    front_inset: float = 0.0
    rear_inset: float = 0.0

    def __post_init__(self) -> None:
        counts = (self.coarse_steps, self.fine_steps, self.most_pixels)
        if min(counts) < 1 or min(self.coarse_interval, self.fine_interval, self.nearest) <= 0:
            raise ConfigurationError(f"a search takes steps and lengths above 0, got {self}")
        if self.most_difference is not None and self.most_difference <= 0:
            raise ConfigurationError(f"a difference that counts is above 0, got {self}")


PUBLISHED = Alignment()
MEASURED = Alignment(
    parabola=True, disparity_offset=0.03, side_inset=0.1, front_inset=0.15, rear_inset=0.1
)
"""The insets and the offset that centre the errors on the procedural world: its cars are rounder
than their boxes, and what shines in their paint lies behind it."""
