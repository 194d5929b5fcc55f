"""Instants of a data set become scans with the poses that are asked for."""

from types import SimpleNamespace

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.validation.connected.recordings import recorded_instants


def _world() -> SimpleNamespace:
    true, measured = np.eye(4), np.eye(4)
    measured[0, 3] = 0.2
    frame = SimpleNamespace(points=np.ones((3, 4), np.float32))
    views = [SimpleNamespace(frame=frame, pose=true, measured_pose=measured, time=0.05)]
    return SimpleNamespace(
        ids=lambda: ["000000", "000001"], views=lambda id: views, instant=lambda id: id
    )


@pytest.mark.parametrize(("poses", "x"), [("measured", 1.2), ("true", 1.0)])
def test_scans_have_the_poses_that_are_asked_for(poses: str, x: float) -> None:
    instants = list(recorded_instants(_world(), poses))  # type: ignore[arg-type]
    assert [instant.id for instant in instants] == ["000000", "000001"]
    assert [instant.truth for instant in instants] == ["000000", "000001"]
    [scan] = instants[0].scans
    assert scan.time == 0.05
    assert scan.in_world()[0].tolist() == [x, 1.0, 1.0]


def test_some_instants_only_and_no_other_poses() -> None:
    chosen = recorded_instants(_world(), ids=["000001"])  # type: ignore[arg-type]
    assert [instant.id for instant in chosen] == ["000001"]
    with pytest.raises(ConfigurationError):
        next(recorded_instants(_world(), "guessed"))  # type: ignore[arg-type]
