"""How an agent is trained, in the YAML form of rl-zoo3: one file for an algorithm, by environment.

    avsec/GhostObject-v1:
      n_envs: 256
      n_timesteps: !!float 1e5
      policy: PlacePolicy
      learning_rate: lin_0.002
      env_kwargs: {scenarios: {name: layouts, seed: 0, count: 400}}
      eval_env_kwargs: {scenarios: {name: layouts, seed: 7, count: 600}}

What rl-zoo3 writes as Python in a string, such as ``policy_kwargs: "dict(net_arch=[64, 64])"``, is
parsed, never evaluated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from avsec_gym.agents.algorithms import ALGORITHMS, argument_names, plain_arguments
from avsec_gym.agents.yaml_files import read_yaml
from avsec_gym.errors import AvsecError, ConfigurationError, DataError
from avsec_gym.registration import CATALOGUE
from avsec_gym.storage.regular_files import is_file
from avsec_gym.suggestions import unknown_name

HYPERPARAMETERS = Path(__file__).parent / "hyperparams"
_REMEDY = "It has an entry for each environment, in the YAML form of rl-zoo3 (docs/agents.md)."
_MOST_ENVS, _MOST_STEPS = 4096, 10**12
_NOT_THE_ENVIRONMENT_S = (
    "id",
    "max_episode_steps",
    "disable_env_checker",
    "num_envs",
    "vectorization_mode",
    "vector_kwargs",
    "wrappers",
)
"""What `gymnasium.make` and `make_vec` take for themselves."""
_NORMALIZE, _OWN = "normalize", ("n_timesteps", "n_envs", "policy", "env_kwargs", "eval_env_kwargs")


@dataclass(frozen=True)
class AgentConfiguration:
    """One entry, checked.

    Args:
        env: The id of the environment, such as ``avsec/GhostObject-v1``.
        algorithm: One of `ALGORITHMS`.
        n_timesteps: Environment steps to train for.
        policy: A name of stable-baselines3, such as ``MlpPolicy``, or of this package,
            ``PlacePolicy`` or ``AimingPolicy``.
        n_envs: Environments side by side.
        env_kwargs: Arguments of the environment that is trained in.
        eval_env_kwargs: What differs in the environment that is judged in: held-out scenes.
        arguments: Arguments of the algorithm, as the file has them.
        file: The user's file that it was read from; None: the package's, or none.
    """

    env: str
    algorithm: str
    n_timesteps: int
    policy: str = "MlpPolicy"
    n_envs: int = 1
    env_kwargs: dict[str, Any] = field(default_factory=dict)
    eval_env_kwargs: dict[str, Any] = field(default_factory=dict)
    arguments: dict[str, Any] = field(default_factory=dict)
    file: Path | None = field(default=None, compare=False)

    @property
    def held_out_kwargs(self) -> dict[str, Any]:
        """All arguments of the environment that is judged in."""
        return self.env_kwargs | self.eval_env_kwargs

    def entry(self) -> dict[str, Any]:
        """The entry as the file has it."""
        facts = asdict(self)
        own = {name: facts[name] for name in _OWN if facts[name] != {}}
        return own | facts["arguments"]


def shipped_configurations(variant: str | None = None) -> dict[str, tuple[str, ...]]:
    """The algorithms that each environment has a shipped entry for.

    Args:
        variant: One of `shipped_variants`; None: the usual entries.
    """
    files = {
        name: read_yaml(path, remedy=_REMEDY) for name, path in _shipped_files(variant).items()
    }
    return {
        entry.id: tuple(name for name, there in files.items() if entry.id in there)
        for entry in CATALOGUE
    }


def shipped_variants() -> tuple[str, ...]:
    """The names of other games with the same environments, such as ``images`` and ``defender``.

    The entries of a variant stand in ``ALGORITHM.VARIANT.yml``.
    """
    return tuple(sorted({path.stem.partition(".")[2] for path in HYPERPARAMETERS.glob("*.*.yml")}))


def configuration_of(
    env: str, algorithm: str, path: str | Path | None = None, variant: str | None = None
) -> AgentConfiguration:
    """The entry of an environment.

    Args:
        env: The environment's id; ``avsec/`` may be left out.
        algorithm: One of `ALGORITHMS`.
        path: The user's file; None: the shipped one.
        variant: One of `shipped_variants`, in place of a file; None: the usual entry.

    Raises:
        ConfigurationError: There is no such environment, algorithm or variant, none is shipped, or
            both a file and a variant are named.
        DataError: The file is damaged, lacks the environment, or has an entry that does not fit.
    """
    env = known_environment(env)
    if algorithm not in ALGORITHMS:
        raise ConfigurationError(
            unknown_name(f"there is no algorithm {algorithm}", algorithm, ALGORITHMS)
        )
    place = _shipped_file(algorithm, variant) if path is None else Path(path)
    if path is not None and variant is not None:
        raise ConfigurationError("--config and --variant exclude each other: give one of them")
    entries = read_yaml(place, remedy=_REMEDY)
    if env not in entries:
        raise DataError(
            f"It has no entry {env}; there are {', '.join(entries) or 'none'}.",
            path=place,
            remedy="Add one, or name another file with --config.",
        )
    found = configuration_from(env, algorithm, entries[env], place)
    return found if path is None else replace(found, file=place)


@contextmanager
def naming_the_file(configuration: AgentConfiguration) -> Iterator[None]:
    """What the environment or the algorithm refuses of a user's file is an error of the file.

    Raises:
        DataError: For any error of this project's, where the configuration is of a user's file.
    """
    try:
        yield
    except AvsecError as error:
        if configuration.file is None:
            raise
        raise DataError(
            f"The entry {configuration.env}: {error}.", path=configuration.file, remedy=_REMEDY
        ) from error


def known_environment(env: str) -> str:
    """The whole id of an environment of the catalogue.

    Raises:
        ConfigurationError: There is none.
    """
    known = [entry.id for entry in CATALOGUE]
    whole = env if "/" in env else f"avsec/{env}"
    if whole not in known:
        raise ConfigurationError(unknown_name(f"there is no environment {env}", whole, known))
    return whole


def configuration_from(env: str, algorithm: str, entry: Any, path: Path) -> AgentConfiguration:
    """An entry, checked against what the algorithm takes.

    Raises:
        DataError: It does not fit.
    """
    if not isinstance(entry, Mapping):
        raise DataError(f"The entry {env} is no mapping.", path=path, remedy=_REMEDY)
    try:
        return _checked(env, algorithm, entry)
    except (ConfigurationError, ValueError) as error:
        raise DataError(f"The entry {env}: {error}.", path=path, remedy=_REMEDY) from error


def _checked(env: str, algorithm: str, entry: Mapping[str, Any]) -> AgentConfiguration:
    if entry.get(_NORMALIZE):
        raise ValueError("observations lie in [-1, 1] as they are, leave normalize out")
    for name in ("env_kwargs", "eval_env_kwargs"):
        if not isinstance(entry.get(name, {}), Mapping):
            raise ValueError(f"{name} is a mapping of arguments, not {entry[name]!r:.60}")
        for argument in entry.get(name, {}):
            if argument in _NOT_THE_ENVIRONMENT_S:
                raise ValueError(f"{name} has {argument}, which is no argument of an environment")
    policy = entry.get("policy", "MlpPolicy")
    if not isinstance(policy, str):
        raise ValueError(f"policy is a name, not {policy!r:.60}")
    arguments = {name: entry[name] for name in entry if name not in (*_OWN, _NORMALIZE)}
    known = argument_names(algorithm)
    for name in arguments:
        if name not in known:
            raise ValueError(unknown_name(f"{algorithm} has no argument {name}", name, known))
    # What cannot be understood is refused here.
    understood = plain_arguments(arguments, algorithm)
    side_by_side = _count(entry, "n_envs", 1, _MOST_ENVS)
    often = understood.get("train_freq")
    if side_by_side > 1 and isinstance(often, tuple) and often[1] == "episode":
        raise ValueError("training after an episode takes n_envs: 1")
    steps = _count(entry, "n_timesteps", None, _MOST_STEPS)
    if often is not None and (waits := often[0] if isinstance(often, tuple) else often) > steps:
        raise ValueError(f"train_freq, {waits:,}, is more than n_timesteps, {steps:,}")
    return AgentConfiguration(
        env,
        algorithm,
        steps,
        policy,
        side_by_side,
        dict(entry.get("env_kwargs", {})),
        dict(entry.get("eval_env_kwargs", {})),
        arguments,
    )


def _count(entry: Mapping[str, Any], name: str, usual: int | None, most: int) -> int:
    given = entry.get(name, usual)
    try:
        value = int(float(given))  # YAML reads 1e5 as text.
    except (TypeError, ValueError, OverflowError):
        value = 0
    if not 1 <= value <= most or isinstance(given, bool):
        raise ValueError(f"{name} is a number from 1 to {most:,}, not {given!r:.60}")
    return value


def _shipped_file(algorithm: str, variant: str | None) -> Path:
    """The package's file of an algorithm.

    Raises:
        ConfigurationError: There is no such variant, or none of this algorithm.
    """
    if variant is not None and variant not in shipped_variants():
        raise ConfigurationError(
            unknown_name(f"there is no variant {variant}", variant, shipped_variants())
        )
    files = _shipped_files(variant)
    if algorithm not in files:
        raise ConfigurationError(
            f"no configuration of {algorithm} is shipped: name a file with --config, or take one of"
            f" {', '.join(files)}"
        )
    return files[algorithm]


def _shipped_files(variant: str | None = None) -> dict[str, Path]:
    """The package's files by algorithm."""
    own = "" if variant is None else f".{variant}"
    paths = {name: HYPERPARAMETERS / f"{name}{own}.yml" for name in sorted(ALGORITHMS)}
    return {name: path for name, path in paths.items() if is_file(path)}
