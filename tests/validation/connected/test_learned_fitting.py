"""The learned comparison, whole: from instants to a model, and from a model to who is named."""

from collections.abc import Callable

import numpy as np
import pytest

from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, make
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.fitting import FittedInstants
from avsec_gym.validation.connected.learned_fitting import fit_learned
from avsec_gym.validation.connected.rays.decision import CANNOT_TELL
from avsec_gym.validation.connected.recordings import RecordedInstant
from avsec_gym.validation.connected.traffic import MessageKind
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.validation.connected.vehicle_scan import VehicleScan
from tests.validation.connected.conftest import Box, pose_at, scan_of

_CAR: Box = (14.0, 3.0, 0.1)


@pytest.fixture(scope="module")
def validator() -> ConnectedValidator:
    made: ConnectedValidator = make(Kind.CONNECTED_VALIDATOR, {"name": "learned", "alarms": 0.2})
    return made


def test_a_ghost_alarms_and_its_victim_is_named(validator: ConnectedValidator) -> None:
    poses = [pose_at(0, 0, 0), pose_at(30, 2, np.pi), pose_at(14, -12, np.pi / 2)]
    clean = [scan_of(pose, _CAR) for pose in poses]
    ghost = [*clean[:1], scan_of(poses[1], _CAR, (15.0, -4.0, -0.2)), *clean[2:]]
    before, after = validator.validate(clean), validator.validate(ghost)
    assert not before.alarm
    assert after.highest_score > before.highest_score + 3
    assert set(after.named[after.named >= 0].tolist()) <= {1}
    assert after.alarm
    assert after.method == "learned"
    # Both methods' messages are sent, and all but the crops within the budget of rays.
    for sent in after.traffic.sent:
        assert sent[MessageKind.CROPS] > 0
        assert sent.total() - sent[MessageKind.CROPS] <= validator.budget.nbytes
    assert {"claim", "witness", "crop", "compare", "decide"} <= set(after.traffic.seconds)


def test_one_witness_names_no_victim(validator: ConnectedValidator) -> None:
    poses = [pose_at(0, 0, 0), pose_at(30, 2, np.pi)]
    scans = [scan_of(poses[0], _CAR), scan_of(poses[1], _CAR, (15.0, -4.0, -0.2))]
    result = validator.validate(scans)
    assert result.alarm
    assert set(result.named[result.named != -2].tolist()) == {CANNOT_TELL}


def test_a_vehicle_whose_messages_are_lost_breaks_nothing(validator: ConnectedValidator) -> None:
    scans = [scan_of(pose_at(0, 0, 0), _CAR), scan_of(pose_at(30, 2, np.pi), _CAR)]
    result = validator.validate(scans, wire=lambda kind, sender, content: [content] * (sender == 0))
    assert not result.alarm
    assert np.isneginf(result.score).all()


def test_a_model_is_learned_from_instants(street: Callable[..., list[VehicleScan]]) -> None:
    # Cars stand a little elsewhere at each instant.
    cars = [(14.0 + 0.4 * number, 3.0, 0.1 * number) for number in range(5)]
    instants = [
        RecordedInstant(f"{number:06d}", tuple(street((car,), (car,), (car,))))
        for number, car in enumerate(cars)
    ]
    done: list[tuple[int, int]] = []
    fit = fit_learned(
        instants,
        len(instants),
        FittedInstants({"layout": "boxes"}, attacks=(PastedObject(distance=(6.0, 14.0)),)),
        read_connected_fit(SHIPPED_FIT),
        on_progress=lambda now, of: done.append((now, of)),
    )
    assert done[-1] == (5, 5)
    assert len(fit.clean_log_odds) == 5
    assert fit.card.attack_free >= 5
    assert fit.card.attacked >= 3
    assert fit.card.held_out_area > 0.9


def test_a_method_without_its_model_is_refused() -> None:
    with pytest.raises(ConfigurationError, match="needs a model"):
        ConnectedValidator(method="learned")
