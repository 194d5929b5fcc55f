"""`avsec run pipeline`: parts that cannot be are refused before anything is rendered."""

from __future__ import annotations

from typing import Any

import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.experiments import pipeline_episodes
from avsec_gym.experiments.pipeline_episodes import PIPELINE
from avsec_gym.runs.experiment import Configuration, with_defaults


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"detector": "dsgnn"}, 'Did you mean "dsgn"'),
        ({"detector": {"name": "dsgn", "weigths": "a"}}, 'Did you mean "weights"'),
        ({"planner": "astr"}, 'Did you mean "astar"'),
        ({"attack": "facul"}, "no attack"),
        ({"attack": {"name": "facula", "radus": 3}}, 'Did you mean "radius"'),
        ({"validator": {"name": "likelihood"}}, "needs the argument 'model'"),
        ({"classifier": "smal"}, 'Did you mean "small"'),
        ({"selector": "smal"}, 'Did you mean "small"'),
        ({"motion": "statik"}, 'Did you mean "static"'),
        ({"response": "stopp"}, 'Did you mean "stop"'),
    ],
    ids=str,
)
def test_a_slip_is_reported_before_scenes_are_made(
    options: dict[str, Any], complaint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def made(_: Configuration) -> None:
        raise AssertionError("scenes are made before the parts are looked at")

    monkeypatch.setattr(pipeline_episodes, "scenes_of", made)
    configuration = with_defaults(Configuration(options=options), [PIPELINE])
    with pytest.raises(ConfigurationError, match=complaint):
        PIPELINE.cells(configuration)
