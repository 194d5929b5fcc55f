"""Configurations in rl-zoo3's YAML form: what is understood, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from torch import nn

from avsec_gym.agents.algorithms import plain_arguments
from avsec_gym.agents.configuration import (
    configuration_of,
    shipped_configurations,
    shipped_variants,
)
from avsec_gym.agents.yaml_files import read_yaml
from avsec_gym.errors import ConfigurationError, DataError

ENTRY = """
avsec/GhostObject-v1:
  n_envs: 4
  n_timesteps: !!float 1e5
  policy: 'MlpPolicy'
  learning_rate: lin_1e-3
  clip_range: 2e-1
  policy_kwargs: "dict(net_arch=dict(pi=[32], vf=[16]), activation_fn=nn.Tanh, ortho_init=False)"
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.yml"
    path.write_text(text)
    return path


def test_a_file_of_rl_zoo3_is_understood(tmp_path: Path) -> None:
    found = configuration_of("GhostObject-v1", "ppo", written(tmp_path, ENTRY))
    assert (found.env, found.n_timesteps, found.n_envs) == ("avsec/GhostObject-v1", 100_000, 4)
    arguments = plain_arguments(found.arguments, "ppo")
    assert arguments["learning_rate"](0.25) == pytest.approx(0.25e-3)
    assert arguments["clip_range"] == 0.2
    assert arguments["policy_kwargs"] == {
        "net_arch": {"pi": [32], "vf": [16]},
        "activation_fn": nn.Tanh,
        "ortho_init": False,
    }


def test_every_environment_has_a_shipped_configuration() -> None:
    for env, algorithms in shipped_configurations().items():
        assert "ppo" in algorithms, env


@pytest.mark.parametrize("variant", [None, *shipped_variants()])
def test_shipped_entries_are_judged_in_other_scenes_than_they_learn_in(variant: str | None) -> None:
    entries = [
        (env, own) for env, all_of in shipped_configurations(variant).items() for own in all_of
    ]
    assert entries
    for env, algorithm in entries:
        own = configuration_of(env, algorithm, variant=variant)
        assert own.env_kwargs["scenarios"] != own.held_out_kwargs["scenarios"], (env, algorithm)


@pytest.mark.parametrize("variant", [None, *shipped_variants()])
def test_rendered_scenes_to_judge_in_are_of_judging_assets(variant: str | None) -> None:
    for env, algorithms in shipped_configurations(variant).items():
        for algorithm in algorithms:
            own = configuration_of(env, algorithm, variant=variant)
            learned, held_out = (
                kwargs["scenarios"] for kwargs in (own.env_kwargs, own.held_out_kwargs)
            )
            if held_out.get("source") in ("mixed", "drives"):
                assert learned["assets"] == "train", (env, algorithm)
                assert held_out["assets"] == "judge", (env, algorithm)


def test_a_defender_drives_by_an_attacked_detector_s_errors() -> None:
    from avsec_gym.closed_loop.error_model.shipped import shipped_error_models

    for algorithm in ("ppo", "sac"):
        perception = configuration_of(
            "ClosedLoop-v0", algorithm, variant="defender"
        ).held_out_kwargs["perception"]
        assert perception["name"] == "error_model"
        model, shipped = perception["model"], shipped_error_models()
        assert model in shipped
        # Its name begins with that of a detector that is left alone.
        assert any(model.startswith(f"{each}_") for each in shipped)


def test_variants_that_there_are_not(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match='Did you mean "images"'):
        configuration_of("PatchAttack-v0", "ppo", variant="image")
    with pytest.raises(ConfigurationError, match="take one of ppo, sac"):
        configuration_of("PatchAttack-v0", "a2c", variant="images")
    with pytest.raises(DataError, match="no entry avsec/GhostObject-v1"):
        configuration_of("GhostObject-v1", "ppo", variant="images")
    with pytest.raises(ConfigurationError, match="--config and --variant"):
        configuration_of("GhostObject-v1", "ppo", written(tmp_path, ENTRY), "images")


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("n_step: 8", 'Did you mean "n_steps"'),
        ("normalize: true", "leave normalize out"),
        ("n_timesteps: many", "n_timesteps is a number"),
        ("env_kwargs: [1]", "env_kwargs is a mapping"),
        ("learning_rate: lin_x", "falls from a number"),
        ("policy_kwargs: \"dict(net_arch=__import__('os').getcwd())\"", "nothing is called"),
        ("policy_kwargs: dict(activation_fn=os.system)", "activation_fn is one of"),
        ("gamma: !!python/object/apply:os.getcwd []", "no sound YAML"),
        ("gamma: .nan", "plain values"),
        ("policy_kwargs: &a {net_arch: [1]}\n  env_kwargs: *a", "aliases"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, line: str, problem: str) -> None:
    timesteps = "" if "n_timesteps" in line else "  n_timesteps: 10\n"
    path = written(tmp_path, f"avsec/GhostObject-v1:\n{timesteps}  {line}\n")
    with pytest.raises(DataError, match=problem) as error:
        configuration_of("GhostObject-v1", "ppo", path)
    assert str(path) in str(error.value)


TAGS = [
    "float",
    "int",
    "bool",
    "null",
    "timestamp",
    "binary",
    "set",
    "omap",
    "pairs",
    "map",
    "seq",
    "str",
]
TEXTS = (
    r'"\UFFFFFFFF"',
    r'"\U00110000"',
    "''",
    "x",
    "[]",
    "{}",
    "[1, 2]",
    "{a: 1}",
    "[[1]]",
    "1_",
    "-",
    "0x",
    "\u00e9",
    "2001-99-99",
)


@pytest.mark.parametrize("tag", TAGS)
def test_a_tag_with_any_text_is_plain_or_refused_by_the_file(tmp_path: Path, tag: str) -> None:
    """PyYAML itself raises an IndexError of the first, a KeyError of the second, and so on."""
    for text in TEXTS:
        path = written(tmp_path, f"a: !!{tag} {text}\n")
        try:
            value = read_yaml(path, remedy="Mend it.")["a"]
        except DataError as error:
            assert str(path) in str(error)  # noqa: PT017
        else:
            assert isinstance(value, float | int | str | list | dict | None)


def test_names_that_there_are_not(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match='Did you mean "avsec/GhostObject-v1"'):
        configuration_of("GhostObjects-v1", "ppo")
    with pytest.raises(ConfigurationError, match="name a file with --config"):
        configuration_of("GhostObject-v1", "a2c")
    with pytest.raises(DataError, match="no entry avsec/GhostObject-v0"):
        configuration_of("GhostObject-v0", "ppo", written(tmp_path, ENTRY))


@pytest.mark.parametrize("often", ["11", "[11, step]", "[11, episode]"])
def test_an_agent_that_would_never_learn_is_refused(tmp_path: Path, often: str) -> None:
    entry = "avsec/GhostObject-v1:\n  n_timesteps: {}\n  train_freq: {}\n"
    path = written(tmp_path, entry.format(10, often))
    with pytest.raises(DataError, match="train_freq, 11, is more than n_timesteps, 10"):
        configuration_of("GhostObject-v1", "sac", path)
    path = written(tmp_path, entry.format(11, often))
    assert configuration_of("GhostObject-v1", "sac", path).n_timesteps == 11
