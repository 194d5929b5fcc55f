"""The agent in the detector's place looks at what it is shown, and finds what it reported."""

from typing import Any

import numpy as np
import pytest

from avsec_gym.attacks.attack import LEFT, RIGHT
from avsec_gym.boxes import Boxes3D
from avsec_gym.envs.reported_boxes import Reported
from avsec_gym.validation.compromised_sensors import Untrusted


class _Frame:
    """Notes what is asked of it; a sensor may be compromised."""

    def __init__(self, compromised: object = None) -> None:
        self.asked: list[object] = []
        self._compromised = compromised

    def image(self, camera: int) -> Any:
        return self._given(camera)

    @property
    def points(self) -> Any:
        return self._given("points")

    def _given(self, what: object) -> Any:
        self.asked.append(what)
        if what == self._compromised:
            raise Untrusted(f"{what} is compromised")
        return np.zeros((1, 4))


def test_reported_boxes_are_found() -> None:
    agent: Any = Reported(2)
    assert len(agent.detect(_Frame())) == 0
    boxes = Boxes3D.empty()
    agent.boxes = boxes
    assert agent.detect(_Frame()) is boxes


@pytest.mark.parametrize(("sensors", "asked"), [(2, [LEFT, RIGHT]), (3, [LEFT, RIGHT, "points"])])
def test_all_that_the_agent_is_shown_is_asked_for(sensors: int, asked: list[object]) -> None:
    frame: Any = _Frame()
    Reported(sensors).detect(frame)
    assert frame.asked == asked


def test_a_compromised_sensor_is_not_detected_with() -> None:
    frame: Any = _Frame("points")
    with pytest.raises(Untrusted):
        Reported(3).detect(frame)
    Reported(2).detect(frame)
