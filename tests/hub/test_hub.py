"""Models go to the hub's layout and come back the same; what is not sound does not get through."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from avsec_gym.agents.agent_folder import load_agent
from avsec_gym.cli import run
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.hub.agents import export_agent, import_agent
from avsec_gym.hub.detectors import export_weights, import_weights
from avsec_gym.hub.readme import hub_license
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.perception.weights.store import read_card


def header(folder: Path) -> dict:
    _, text, body = (folder / "README.md").read_text().split("---\n", 2)
    assert body.strip().startswith("# ")
    return yaml.safe_load(text)


@pytest.fixture(scope="module")
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("hub") / "pixor"
    export_weights(shipped_weights("pixor_small"), folder)
    return folder


@pytest.fixture(scope="module")
def agent(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("hub") / "agent"
    export_agent("ghost_place", folder)
    return folder


def test_weights_come_back_byte_for_byte(weights: Path, tmp_path: Path) -> None:
    assert sorted(path.name for path in weights.iterdir()) == [
        "README.md",
        "config.json",
        "model.safetensors",
    ]
    out = tmp_path / "mine.safetensors"
    card = import_weights(weights, out)
    shipped = shipped_weights("pixor_small")
    assert out.read_bytes() == shipped.read_bytes()
    assert card == read_card(shipped) == read_card(out)


def test_the_card_has_what_the_hub_reads(weights: Path, agent: Path) -> None:
    of_weights, of_agent = header(weights), header(agent)
    assert of_weights["license"] == of_agent["license"] == "mit"
    assert of_weights["pipeline_tag"] == "object-detection"
    card = read_card(shipped_weights("pixor_small"))
    assert card is not None
    (result,) = of_weights["model-index"][0]["results"]
    metrics = {metric["type"]: metric["value"] for metric in result["metrics"]}
    assert metrics == card.metrics
    assert of_agent["pipeline_tag"] == "reinforcement-learning"
    (result,) = of_agent["model-index"][0]["results"]
    assert result["dataset"]["name"] == "avsec/GhostObject-v1"
    assert {metric["type"] for metric in result["metrics"]} == {"success_rate", "reward"}


def test_the_hub_s_own_library_reads_the_card(weights: Path, agent: Path) -> None:
    hub = pytest.importorskip("huggingface_hub")
    for folder in (weights, agent):
        data = hub.ModelCard.load(folder / "README.md").data
        assert data.license == "mit"
        assert data.library_name == "avsec-gym"
        assert len(data.eval_results) == len(
            header(folder)["model-index"][0]["results"][0]["metrics"]
        )


def test_an_agent_comes_back_and_acts_alike(agent: Path, tmp_path: Path) -> None:
    out = tmp_path / "back"
    card = import_agent(agent, out)
    assert card.env == "avsec/GhostObject-v1"
    first, second = load_agent("ghost_place"), load_agent(out)
    shape = first.policy.observation_space.shape
    seen = np.random.default_rng(0).uniform(-1, 1, (5, *shape)).astype(np.float32)
    np.testing.assert_array_equal(first.predict(seen)[0], second.predict(seen)[0])


def test_what_is_not_sound_does_not_get_through(weights: Path, agent: Path, tmp_path: Path) -> None:
    for folder, take in ((weights, import_weights), (agent, import_agent)):
        broken = tmp_path / folder.name
        broken.mkdir()
        for path in folder.iterdir():
            (broken / path.name).write_bytes(path.read_bytes())
        content = bytearray((broken / "model.safetensors").read_bytes())
        content[-1] ^= 1
        (broken / "model.safetensors").write_bytes(content)
        with pytest.raises(DataError, match="not the one of its card"):
            take(broken, tmp_path / "out.safetensors")
        (broken / "model.safetensors").write_bytes(b"\x80\x04.")
        with pytest.raises(DataError, match=r"model\.safetensors"):
            take(broken, tmp_path / "out.safetensors")
    assert not (tmp_path / "out.safetensors").exists()


def test_a_licence_is_named_or_known() -> None:
    assert hub_license(None, "MIT") == hub_license("mit", "MIT") == "mit"
    assert hub_license("cc-by-nc-sa-4.0", None) == "cc-by-nc-sa-4.0"
    for given, recorded in ((None, None), ("Free for all", None), ("apache-2.0", "MIT")):
        with pytest.raises(ConfigurationError, match="--license"):
            hub_license(given, recorded)


def test_the_commands(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "road"
    assert run(["hub", "export", "road_type_small", "--out", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["files"] == ["model.safetensors", "config.json", "README.md"]
    assert run(["hub", "export", "road_type_small", "--out", str(out)]) == 1
    assert "exists" in capsys.readouterr().err
    back = tmp_path / "back.safetensors"
    assert run(["hub", "import", str(out), "--out", str(back), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["network"] == "road_type"
    assert run(["hub", "import", str(tmp_path), "--out", str(back)]) == 1
    assert "neither config.yml nor config.json" in capsys.readouterr().err
