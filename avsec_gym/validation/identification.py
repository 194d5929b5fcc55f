"""Which sensors are attacked: algorithms 1 and 2 (thesis, section 3.4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

from avsec_gym.errors import ConfigurationError
from avsec_gym.sensor_system import Triple

ErrorState = Callable[[Triple], bool]
"""e_{i,j,k}: whether E_{i,j,k} exceeds its threshold; asked only where the answer is needed."""


@dataclass(frozen=True)
class Identification:
    """The answer of algorithm 2, and how firm it is.

    Args:
        attacked: A, positions of the attacked sensors in the order in which they were found.
        zero: The element of **e** that lemma 1 started from; None where all that were asked for
            are 1.
        other_answers: The answers of lemma 1 from other zeros of the same **e**, where they differ.
        unexplained: Elements of that **e** which the answer contradicts, so that some element is
            wrong; wherever zeros disagree there are such.
        limit_exceeded: No triple at all was consistent, so that more than n - 2 sensors are
            attacked, or elements are wrong: `attacked` then means little, and of the first three
            sensors nothing.
    """

    attacked: tuple[int, ...]
    zero: Triple | None
    other_answers: tuple[frozenset[int], ...] = ()
    unexplained: tuple[Triple, ...] = ()
    limit_exceeded: bool = False

    @property
    def named(self) -> frozenset[int]:
        """The sensors that are reported as attacked: A, but none beyond the limit.

        No two sensors agree there, and a dropped sensor is no more suspicious than one that is
        left.
        """
        return frozenset() if self.limit_exceeded else frozenset(self.attacked)

    @property
    def doubtful(self) -> frozenset[int]:
        """Sensors that are not named, and not cleared either.

        Those of an element that is 1 though no named sensor is in it, those that another zero
        names, and beyond the limit all.
        """
        named = self.named
        strange = [{*triple} for triple in self.unexplained if not named & {*triple}]
        last = [{0, 1, 2, *self.attacked}] if self.limit_exceeded else []
        return frozenset().union(*strange, *self.other_answers, *last) - named


def identify_attacked_sensors(state: ErrorState, sensors: int) -> Identification:
    """Algorithm 2: exact where e_{i,j,k} = s_i or s_j or s_k and at most n - 2 are attacked.

    Lemma 1 starts from the first zero of **e** and needs no limit: two sensors that agree with the
    reference are sound.  Lemma 2 does: where all of **e** is 1, S_n is attacked; it is dropped, and
    what is left is looked at if n > 3.  At n = 3 the thesis ends and takes S_0 to S_2 for sound;
    here e_{0,1,2} is asked beside that, since it is 0 if the limit is kept.

    Args:
        state: The states of the triples, e_{i,j,k}.
        sensors: The number of sensors, n + 1.

    Raises:
        ConfigurationError: Fewer than four sensors, of which none can be identified.

    Example:
        >>> identify_attacked_sensors(lambda triple: 1 in triple, 4).attacked
        (1,)
    """
    if sensors < 4:
        raise ConfigurationError(
            f"to identify takes a system of four sensors or more, got {sensors}; three can only "
            "detect"
        )
    dropped: tuple[int, ...] = ()
    # S_n is the reference; while all elements of e are 1, it is attacked (lemma 2) and is dropped.
    for n in range(sensors - 1, 2, -1):
        vector = disparity_error_state_vector(state, n)
        zeros = [triple for triple, exceeded in vector.items() if not exceeded]
        if zeros:
            # Lemma 1 answers from any zero; where errors are noisy, zeros may disagree.
            answer, *others = dict.fromkeys(_by_lemma_1(vector, zero) for zero in zeros)
            unexplained = [t for t, exceeded in vector.items() if exceeded != bool(answer & {*t})]
            attacked = (*dropped, *sorted(answer))
            return Identification(attacked, zeros[0], tuple(others), tuple(unexplained))
        dropped = (*dropped, n)
    return Identification(dropped, None, limit_exceeded=bool(state((0, 1, 2))))


def disparity_error_state_vector(state: ErrorState, n: int) -> dict[Triple, bool]:
    """Algorithm 1: **e** = [e_{0,1,n}, e_{0,2,n}, ..., e_{n-2,n-1,n}]; S_n is the reference."""
    return {(i, j, n): bool(state((i, j, n))) for i, j in combinations(range(n), 2)}


def _by_lemma_1(vector: Mapping[Triple, bool], zero: Triple) -> frozenset[int]:
    """S_i0, S_j0 and S_n agree, so they are sound; a sensor that contradicts S_i0 is not.

    The thesis prints e_{i0,i,l-1}; its proof shows that n is meant.
    """
    i0, _, n = zero
    others = (i for i in range(n) if i != i0)
    return frozenset(i for i in others if vector[min(i, i0), max(i, i0), n])
