"""Scales, grids and presets of DSGN."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.detectors.dsgn.grid import DepthScale, GridAxis


@pytest.mark.parametrize("power", [1, 0, -1])
def test_a_scale_runs_from_far_to_near_in_equal_steps_of_its_power(power):
    scale = DepthScale(48.0, 3.0, 17, power)
    depths = scale.values()
    assert depths[[0, -1]] == pytest.approx([48.0, 3.0])
    steps = np.diff(np.log(depths) if power == 0 else depths**power)
    assert steps == pytest.approx(np.full(16, steps[0]))
    assert scale.position(depths) == pytest.approx(np.linspace(-1, 1, 17))


def test_the_originals_numbers():
    original = DsgnConfiguration.preset("default")
    i = np.arange(48)
    assert original.planes.values()[::-1] == pytest.approx(((i + 0.5) * 4 + 10) * 0.2)
    assert original.bins.values()[::-1] == pytest.approx((np.arange(192) + 10) * 0.2)
    assert original.grid.z.centres()[[0, 1, -1]] == pytest.approx([40.3, 40.1, 2.1])
    assert original.grid.y.centres()[[0, -1]] == pytest.approx([2.9, -0.9])
    assert original.grid.x.centres()[[0, -1]] == pytest.approx([-30.3, 30.3])


def test_an_axis_may_run_backwards():
    assert GridAxis(4.0, 0.0, 4).centres() == pytest.approx([3.5, 2.5, 1.5, 0.5])


def test_small_tells_a_step_of_depth_from_the_next():
    """Neighbouring planes lie at most 1.3 feature pixels apart: none of them skips a match."""
    small = DsgnConfiguration.preset("small")
    focal_times_baseline = 721.5 * 0.54 * small.input_size[1] / 1242
    disparities = focal_times_baseline / small.planes.values() / 4
    assert np.diff(disparities).max() < 1.3


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"padded_size": (380, 1248)}, "padded_size"),
        ({"pooled_heights": 3}, "pooled"),
        ({"planes": DepthScale(40.0, 2.0, 50)}, "planes"),
        ({"input_size": (400, 1248)}, "do not fit"),
        ({"correlation_groups": 5}, "groups"),
        ({"volume_begins_with_hourglass": True, "correlation_groups": 8}, "hourglass"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(change, complaint):
    with pytest.raises(ConfigurationError, match=complaint):
        replace(DsgnConfiguration.preset("default"), **change)


def test_unknown_presets_and_scales_are_refused():
    with pytest.raises(ConfigurationError, match="no DSGN is called 'big'"):
        DsgnConfiguration.preset("big")
    with pytest.raises(ConfigurationError, match="far to near"):
        DepthScale(2.0, 40.0, 8)
