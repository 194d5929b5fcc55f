"""Primitives that begin at a state that was reached."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.closed_loop.made_primitives import primitives_from
from avsec_gym.errors import ConfigurationError
from avsec_gym.planners.reachability import reach_table


@pytest.mark.parametrize("start", [(7.3, 0.05), (2.05, -0.45), (9.4, 0.0)])
def test_what_leads_onto_a_grid_is_laid_out_as_a_whole_set_is(start: tuple[float, float]) -> None:
    made = primitives_from(*start, (6.0, 8.0))
    assert made.grid is not None
    assert len(made.starting_at(*start)) == len(made) - len(made.grid) > 0
    whole = replace(made, grid=None)
    np.testing.assert_array_equal(made.follows, whole.follows)
    for one, other in zip(made.arrays, whole.arrays, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(reach_table(made, 12), reach_table(whole, 12))


def test_starts_on_the_grid_share_it() -> None:
    assert primitives_from(6.0, 0.07, (6.0, 8.0)) is primitives_from(2.0, 0.0, (6.0, 8.0))


def test_what_does_not_lead_onto_the_grid_is_refused() -> None:
    made = primitives_from(7.3, 0.05, (6.0, 8.0))
    assert made.grid is not None
    states = made.states.copy()
    states[-1, -1, 2] += 0.5
    with pytest.raises(ConfigurationError, match="onto the grid"):
        replace(made, states=states).arrays  # noqa: B018
