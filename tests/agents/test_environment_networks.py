"""Agents know the weights of the networks that they were trained against."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch

from avsec_gym.agents import environment_networks as networks_module
from avsec_gym.agents import training
from avsec_gym.agents.agent_folder import (
    CARD,
    AgentCard,
    load_agent,
    read_agent_card,
    save_agent,
    write_configuration,
)
from avsec_gym.agents.configuration import AgentConfiguration
from avsec_gym.agents.environment_networks import all_weights, environment_networks
from avsec_gym.agents.learner import make_policy, single
from avsec_gym.agents.training import TrainingSitting, train_agent
from avsec_gym.closed_loop.error_model.shipped import named_error_model
from avsec_gym.perception.detectors.recorded import Oracle
from avsec_gym.perception.weights.weights_hash import weights_hash
from avsec_gym.registry import Kind, register

LASER = "avsec/FaculaAttack-v0"
CAR = AgentConfiguration(LASER, "ppo", 64, env_kwargs={"detector": "learned"})
GHOSTS = AgentConfiguration(
    "avsec/GhostObject-v1",
    "ppo",
    64,
    "PlacePolicy",
    4,
    {"scenarios": {"name": "layouts", "seed": 0, "count": 8}},
    arguments={"n_steps": 8, "batch_size": 16, "n_epochs": 2},
)


class Learned(Oracle):
    """A detector with a network, which it does not ask."""

    name = "learned"
    network = torch.nn.Linear(2, 2)


@pytest.fixture(autouse=True)
def learned(monkeypatch: pytest.MonkeyPatch) -> str:
    """The hash of the weights of a detector that has a name."""
    monkeypatch.setattr("avsec_gym.registry._REGISTERED", {})
    register(Kind.DETECTOR, "learned", Learned)
    monkeypatch.setattr(networks_module, "_REPORTED", set())
    found = weights_hash(Learned())
    assert found is not None
    return found


def networks_of(env: str, **arguments: Any) -> dict[str, str]:
    environment = single(env, arguments)
    found = environment_networks(environment)
    environment.close()
    return found


def test_networks_are_found_behind_whatever_stands_before_them(learned: str) -> None:
    behind = {"name": "defended", "detector": "learned"}
    tampered = {"name": "attacked", "detector": behind, "attack": "random_noise"}
    for detector in ("learned", behind, tampered):
        assert networks_of(LASER, detector=detector) == {"detector learned": learned}
    found = networks_of(LASER, detector="oracle", classifier="small", selector="small")
    assert list(found) == ["classifier motion", "selector road_type"]
    assert len({*found.values()}) == 2


def test_a_car_without_a_network_has_none() -> None:
    assert networks_of(LASER, detector="oracle") == {}
    assert networks_of("avsec/GhostObject-v1") == {}
    # Recordings, in which no car drives.
    assert networks_of("avsec/SensorIdentification-v0") == {}
    assert networks_of("avsec/ConnectedValidation-v0") == {}


def test_a_driving_car_has_those_that_it_perceives_by(learned: str) -> None:
    loop = "avsec/ClosedLoop-v0"
    assert networks_of(loop) == {}
    assert networks_of(loop, perception="blind") == {}
    sensing = {"perception": "stereo", "detector": "learned"}
    assert networks_of(loop, **sensing) == {"detector learned": learned}
    attacked = networks_of("avsec/ClosedLoopAttack-v0", kind="facula", **sensing)
    assert attacked == {"detector learned": learned}
    drawn = networks_of(loop, perception={"name": "error_model", "model": "dsgn_patch"})
    card = named_error_model("dsgn_patch").card
    assert drawn == {"error model of the detector dsgn": card["weights"]}


def stored(folder: Path, networks: dict[str, list[str]]) -> Path:
    """An agent that has learned nothing, with the weights that its card names."""
    environment = single(LASER, CAR.env_kwargs)
    card = AgentCard(LASER, CAR.env_kwargs, {}, "ppo", 0, 64, 1.0, True, 0, "")
    folder.mkdir()
    write_configuration(folder, CAR, 0)
    save_agent(folder, make_policy(CAR, environment), replace(card, networks=networks))
    environment.close()
    return folder


def test_an_agent_that_plays_against_other_weights_is_reported_once(
    tmp_path: Path, learned: str, caplog: pytest.LogCaptureFixture
) -> None:
    known = {
        "other": {"detector learned": ["0" * 64]},
        "changed": {"detector learned": ["1" * 64, learned]},
        "today": {"detector learned": [learned]},
        "another_network": {"detector dsgn": ["0" * 64]},
        "none": {},
    }
    reported = {}
    for name, networks in known.items():
        folder = stored(tmp_path / name, networks)
        caplog.clear()
        for _ in range(2):
            assert load_agent(folder).card.networks == networks
        reported[name] = list(caplog.messages)
    counts = {name: len(messages) for name, messages in reported.items()}
    assert counts == {"other": 1, "changed": 1, "today": 0, "another_network": 0, "none": 0}
    [message] = reported["other"]
    assert "other weights of the detector learned (00000000)" in message
    assert f"than it plays against now ({learned[:8]})" in message


def test_a_card_of_before_is_read(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    folder = stored(tmp_path / "agent", {})
    facts = json.loads((folder / CARD).read_text())
    del facts["networks"]
    (folder / CARD).write_text(json.dumps(facts))
    assert read_agent_card(folder).networks == {}
    load_agent(folder)
    assert not caplog.messages


def test_a_training_records_the_weights_of_all_its_sittings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    assert train_agent(GHOSTS, tmp_path / "none", 0, TrainingSitting(32)).networks == {}
    out = tmp_path / "agent"
    for steps, digest, expected in (
        (32, "a" * 64, ["a" * 64]),
        (64, "a" * 64, ["a" * 64]),
        (96, "b" * 64, ["a" * 64, "b" * 64]),
    ):
        monkeypatch.setattr(
            training, "environment_networks", lambda _, found=digest: {"detector dsgn": found}
        )
        caplog.clear()
        card = train_agent(GHOSTS, out, 0, TrainingSitting(steps, resume=steps > 32))
        assert card.networks == read_agent_card(out).networks == {"detector dsgn": expected}
        assert len(caplog.messages) == len(expected) - 1
    assert "other weights of the detector dsgn (aaaaaaaa)" in caplog.messages[0]


def test_weights_of_the_last_sitting_stand_at_the_end() -> None:
    before = {"detector dsgn": ["a", "b"], "surrogate dsgn": ["a"]}
    found = all_weights(before, {"detector dsgn": "a", "classifier motion": "c"})
    assert found == {
        "detector dsgn": ["b", "a"],
        "surrogate dsgn": ["a"],
        "classifier motion": ["c"],
    }
