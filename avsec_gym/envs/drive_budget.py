"""What an attacker on a driving car may spend: frames under attack, and energy."""

from __future__ import annotations

from dataclasses import dataclass

from avsec_gym.argument_checks import number, whole_number


@dataclass(frozen=True)
class DriveBudget:
    """The budget of one drive.

    Args:
        frames: Frames, a tenth of a second each, in which anything is up.
        energy: The energy of all frames together; a frame of all that the attack can do takes 1.
        price: Reward that the whole energy costs, from 0 to 1.

    Raises:
        ConfigurationError: A number is out of range.
    """

    frames: int = 20
    energy: float = 15.0
    price: float = 0.1

    def __post_init__(self) -> None:
        object.__setattr__(self, "frames", whole_number("frames", self.frames, 1, 10_000))
        object.__setattr__(self, "energy", number("energy", self.energy, 0.01, 10_000.0))
        object.__setattr__(self, "price", number("price", self.price, 0.0, 1.0))


@dataclass(frozen=True)
class Spent:
    """What was spent of a budget."""

    frames: int = 0
    energy: float = 0.0

    def allows(self, effort: float, budget: DriveBudget) -> bool:
        """Whether the budget has a frame and so much energy left."""
        return self.frames < budget.frames and self.energy + effort <= budget.energy + 1e-9

    def more(self, effort: float) -> Spent:
        """The budget after one more frame that takes so much energy; 0: nothing was up."""
        return Spent(self.frames + (effort > 0), self.energy + effort)

    def left(self, budget: DriveBudget) -> tuple[float, float]:
        """Shares of the frames and of the energy that are left."""
        return 1.0 - self.frames / budget.frames, max(0.0, 1.0 - self.energy / budget.energy)
