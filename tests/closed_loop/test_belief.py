"""What a perception means to the planner."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.closed_loop.belief import belief_of
from avsec_gym.closed_loop.perception import TruthPerception
from avsec_gym.errors import ConfigurationError
from avsec_gym.scenario.scene import Motion
from tests.closed_loop.attack.surroundings import OTHERS, around

POSE = (5.0, -1.0, 0.3)


def test_believed_objects_are_where_they_are_in_the_world() -> None:
    seen = around(POSE)
    belief = belief_of(TruthPerception().perceive(seen), seen, Motion.TRUTH)
    np.testing.assert_allclose(belief.poses, OTHERS, atol=1e-9)
    assert not belief.stops


def test_a_car_that_stops_at_an_alarm_has_classified_nothing() -> None:
    """Its boxes have no `moving`, which a classifier gives; any other car needs it."""
    seen = around(POSE)
    known = TruthPerception().perceive(seen)
    unclassified = replace(known, believed=replace(known.believed, moving=None))
    with pytest.raises(ConfigurationError, match="name a classifier"):
        belief_of(unclassified, seen, Motion.CLASSIFIER)
    belief = belief_of(replace(unclassified, stops=True), seen, Motion.CLASSIFIER)
    assert belief.stops
    assert (belief.speeds == 0).all()
