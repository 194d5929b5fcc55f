"""Algorithms 1 and 2 against every attack there is."""

from __future__ import annotations

from itertools import chain, combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from avsec_gym.errors import ConfigurationError
from avsec_gym.sensor_system import Triple
from avsec_gym.validation.identification import (
    disparity_error_state_vector,
    identify_attacked_sensors,
)


def subsets(n: int) -> list[frozenset[int]]:
    """Of the sensors 0 to n, by size."""
    sizes = (combinations(range(n + 1), size) for size in range(n + 2))
    return [frozenset(members) for members in chain.from_iterable(sizes)]


def explanations(n: int) -> dict[frozenset[int], list[frozenset[int]]]:
    """Which attacks within the limit have the same states in all triples with a reference >= 3."""
    triples = [{*triple} for triple in combinations(range(n + 1), 3) if triple[2] >= 3]
    within = [subset for subset in subsets(n) if len(subset) <= n - 2]
    seen = {subset: tuple(bool(subset & triple) for triple in triples) for subset in within}
    alike: dict[tuple[bool, ...], list[frozenset[int]]] = {}
    for subset, states in seen.items():
        alike.setdefault(states, []).append(subset)
    return {subset: alike[states] for subset, states in seen.items()}


@pytest.mark.parametrize("n", [3, 4, 5, 6, 7])
def test_every_attack_within_the_limit_is_identified(n: int) -> None:
    explained = explanations(n)
    for attacked in subsets(n):
        found = identify_attacked_sensors(lambda triple, a=attacked: bool(a & set(triple)), n + 1)
        if len(attacked) <= n - 2:
            assert not found.doubtful
            assert set(found.attacked) == found.named == attacked
            assert len(found.attacked) == len(attacked)
            # No other one within the limit would look the same.
            assert explained[attacked] == [attacked]


@pytest.mark.parametrize("n", [3, 4, 5, 6, 7])
def test_beyond_the_limit_it_says_so(n: int) -> None:
    for attacked in subsets(n):
        if len(attacked) > n - 2:
            found = identify_attacked_sensors(
                lambda triple, a=attacked: bool(a & set(triple)), n + 1
            )
            # Fewer than three sound sensors: no triple is consistent.
            assert found.limit_exceeded
            assert found.zero is None
            assert found.attacked == tuple(range(n, 2, -1))
            # No sensor is reported, and none cleared.
            assert not found.named
            assert found.doubtful == set(range(n + 1))


def test_only_what_is_needed_is_asked_for() -> None:
    asked: list[Triple] = []

    def state(triple: Triple) -> bool:
        asked.append(triple)
        return 5 in triple or 0 in triple

    found = identify_attacked_sensors(state, 6)
    assert found.attacked == (5, 0)
    assert found.zero == (1, 2, 4)
    assert {triple[2] for triple in asked} == {5, 4}
    assert len(asked) == len(set(asked)) == 10 + 6


def test_the_vector_is_ordered_as_in_the_thesis() -> None:
    vector = disparity_error_state_vector(lambda triple: triple == (0, 2, 3), 3)
    assert list(vector.items()) == [((0, 1, 3), False), ((0, 2, 3), True), ((1, 2, 3), False)]


def test_what_does_not_fit_together_is_reported() -> None:
    # S_1 and S_2 agree with S_0, but not with each other: one element is wrong.
    found = identify_attacked_sensors(lambda triple: triple == (1, 2, 3), 4)
    assert (found.attacked, found.zero) == ((), (0, 1, 3))
    assert (found.other_answers, found.unexplained) == ((), ((1, 2, 3),))
    assert found.doubtful == {1, 2, 3}


@given(st.integers(3, 5).flatmap(lambda n: st.tuples(st.just(n), st.integers(0, 2 ** (n * n)))))
def test_zeros_disagree_only_where_something_is_unexplained(case: tuple[int, int]) -> None:
    n, bits = case
    states = {triple: bits >> i & 1 for i, triple in enumerate(combinations(range(n + 1), 3))}
    found = identify_attacked_sensors(lambda triple: bool(states[triple]), n + 1)
    if found.other_answers:
        assert found.unexplained
    if found.zero is not None:
        reference = found.zero[2]
        expected = {
            t
            for t in states
            if t[2] == reference
            and states[t] != bool({s for s in found.attacked if s < reference} & set(t))
        }
        assert set(found.unexplained) == expected
        # Whatever speaks against the answer is said of some sensor.
        assert any(states[triple] for triple in states if triple[2] == reference) == bool(
            {s for s in found.attacked if s < reference} | found.doubtful
        )
        assert all(found.doubtful & set(t) for t in expected if states[t])
    assert found.named == (frozenset() if found.limit_exceeded else set(found.attacked))
    if found.limit_exceeded:
        assert found.doubtful == set(range(n + 1))


def test_zeros_that_disagree_are_reported() -> None:
    states = {(0, 1, 4): 0, (0, 2, 4): 1, (0, 3, 4): 0, (1, 2, 4): 0, (1, 3, 4): 1, (2, 3, 4): 1}
    found = identify_attacked_sensors(lambda triple: bool(states[triple]), 5)
    assert found.attacked == (2,)
    assert found.other_answers == (frozenset({3}),)
    assert found.doubtful == {1, 3, 4}


def test_three_sensors_cannot_identify() -> None:
    with pytest.raises(ConfigurationError, match="four sensors"):
        identify_attacked_sensors(lambda triple: False, 3)
