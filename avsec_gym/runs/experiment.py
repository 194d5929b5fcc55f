"""What an experiment is: a question, and the cells of work whose results answer it.

A cell names its work and the arguments of it, and that is all it is: two experiments that ask for
the same cell share it, and it is done once.  What does the cells is no part of the experiment but a
work of its own, made once in each process::

    class AttackedEpisodes:
        def __init__(self, configuration: Configuration) -> None: ...  # loads detectors, scenes

        def __call__(self, detector: str, alpha: float, scenario: str) -> CellResult: ...

    def cells(configuration: Configuration) -> list[Cell]:
        work = "my_package.attacked:AttackedEpisodes"
        return [Cell.of(work, id, detector="dsgn", alpha=0.4, scenario=id) for id in ...]

    SAFETY = Experiment("safety", "Does the car still drive safely?", "Table 5.2", cells)
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.runs.renamed import first_place
from avsec_gym.storage.portable_names import local, portable
from avsec_gym.suggestions import unknown_name

if TYPE_CHECKING:
    from avsec_gym.boxes import Boxes3D
    from avsec_gym.metrics.safety import SafetyRecord


@dataclass(frozen=True)
class Configuration:
    """What the results of a run depend on, beside its experiments.

    Args:
        scenarios: The name of a set or folder of scenes.
        limit: How many of them at most.
        seed: The seed of everything that is drawn.
        options: The options of the experiments, by name; values are JSON.

    Raises:
        ConfigurationError: A number is too small, or an option is no JSON.
    """

    scenarios: str = "mixed"
    limit: int | None = None
    seed: int = 0
    options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.limit is not None and self.limit < 1:
            raise ConfigurationError(f"--limit is 1 or more, got {self.limit}")
        if self.seed < 0:
            raise ConfigurationError(f"a seed is 0 or more, got {self.seed}")
        try:
            options = json.loads(json.dumps(dict(self.options), allow_nan=False))
        except (TypeError, ValueError) as error:
            raise ConfigurationError(f"options are JSON: {error}") from error
        object.__setattr__(self, "options", options)

    def to_json(self) -> dict[str, Any]:
        """All fields."""
        return asdict(self)


@dataclass(frozen=True)
class Cell:
    """The least piece of work that is done, stored and resumed.

    Args:
        work: The place of its work, ``"module:attribute"``: a `Work`.
        key: Arguments of the work as JSON with sorted names; `of` makes it.
        group: Cells of one group are done by one process, one after another where possible, so
            that it can keep what they share, such as a scene.
    """

    work: str
    key: str
    group: str = field(default="", compare=False)

    @classmethod
    def of(cls, work: str, group: str = "", /, **arguments: Any) -> Cell:
        """A cell with arguments that JSON can hold; 1 and 1.0 are two arguments.

        Raises:
            ConfigurationError: JSON cannot hold them.
        """
        try:
            key = json.dumps(
                portable(arguments), sort_keys=True, separators=(",", ":"), allow_nan=False
            )
        except (TypeError, ValueError) as error:
            raise ConfigurationError(
                f"a cell of {work} has arguments that are no JSON: {error}"
            ) from error
        return cls(work, key, group)

    @property
    def arguments(self) -> dict[str, Any]:
        """What its work is called with."""
        return dict(local(json.loads(self.key)))

    @property
    def id(self) -> str:
        """Sixteen hexadecimal digits that stand for work and arguments."""
        named = f"{first_place(self.work)} {self.key}"
        return hashlib.sha256(named.encode()).hexdigest()[:16]


@dataclass(frozen=True, slots=True)
class EpisodeRow:
    """What became of one episode.

    Args:
        setting: The circumstances, such as ``dsgn thesis_pgd-0.4``; with the strength, the
            planner, the scenario and the intention it is unique in a run.
        record: Scenario, intention and outcome.
        strength: The strength of the attack, such as its steps.
        planner: The planner's name.
    """

    setting: str
    record: SafetyRecord
    strength: float = 0.0
    planner: str = "astar"


@dataclass(frozen=True, eq=False)
class DetectionRow:
    """What a detector saw in a scenario; unique in a run by setting, strength and scenario."""

    setting: str
    scenario: str
    boxes: Boxes3D
    strength: float = 0.0


@dataclass(frozen=True, slots=True)
class Measurement:
    """Any other number, such as a loss; unique in a run by everything but its value.

    NaN is stored as NULL, and read as NaN again.
    """

    setting: str
    scenario: str
    name: str
    value: float
    strength: float = 0.0


@dataclass(frozen=True, eq=False)
class CellResult:
    """The result of a cell.

    Args:
        episodes: Outcomes of episodes.
        detections: Boxes, so that precision can be computed from the run alone.
        measurements: Other numbers.
        seconds: How long each part took, by name.
    """

    episodes: Sequence[EpisodeRow] = ()
    detections: Sequence[DetectionRow] = ()
    measurements: Sequence[Measurement] = ()
    seconds: Mapping[str, float] = field(default_factory=dict)


Work = Callable[[Configuration], Callable[..., CellResult]]
"""Made once in each process, which may take seconds; then called with the arguments of cells.

Its results depend on the configuration and the arguments only: never on the process, on the time,
or on the cells that were done before.
"""


def _no_inputs(configuration: Configuration) -> Mapping[str, Path]:
    return {}


@dataclass(frozen=True)
class Experiment:
    """A table or figure.

    Args:
        name: The name on the command line.
        question: The question that it answers, one line.
        thesis: Place in the thesis, such as ``Table 5.2``; empty if it goes beyond.
        cells: All of them, in the order in which they should be done; cheap, and the same
            whenever it is asked.
        inputs: Files and folders that the results depend on, such as weights and scenes, by name.
            A run keeps their hashes and does not go on with others.
        options: Names of `Configuration.options` that it knows, and their defaults.
        usual: Scenarios, and how many of them, where the user names none.
        section: ``"module:function"`` that makes its sections of a report, see
            `avsec_gym.runs.section`; empty: its rates stand among those of other settings.
        alone: Whether a run that was asked for it alone is shown by its section alone; other runs
            that share its cells are then shown without it.
    """

    name: str
    question: str
    thesis: str
    cells: Callable[[Configuration], Sequence[Cell]]
    inputs: Callable[[Configuration], Mapping[str, Path]] = _no_inputs
    options: Mapping[str, Any] = field(default_factory=dict)
    usual: Configuration = Configuration()
    section: str = ""
    alone: bool = False


def with_defaults(configuration: Configuration, experiments: Sequence[Experiment]) -> Configuration:
    """The configuration with a value for every option that the experiments know.

    Raises:
        ConfigurationError: None of them knows an option, or its value is of another type than its
            default.
    """
    defaults: dict[str, Any] = {}
    for experiment in experiments:
        defaults |= experiment.options
    for name in configuration.options:
        if name not in defaults:
            problem = f"--options: there is no option {name!r}"
            raise ConfigurationError(unknown_name(problem, name, sorted(defaults) or ["none"]))
    check_options(configuration.options, defaults)
    return replace(configuration, options=defaults | dict(configuration.options))


def check_options(options: Mapping[str, Any], defaults: Mapping[str, Any]) -> None:
    """Refuse the value of an option that is of another type than its default.

    Args:
        options: Values by name; those without a default are passed over.
        defaults: Defaults by name.

    Raises:
        ConfigurationError: A value is of another type.
    """
    for name, value in options.items():
        if name in defaults and not _same_type(value, defaults[name]):
            raise ConfigurationError(
                f"the option {name} is like {json.dumps(defaults[name])}, got {json.dumps(value)}"
            )


def _same_type(value: Any, default: Any) -> bool:
    if isinstance(default, bool) or isinstance(value, bool):
        return type(value) is type(default)
    if isinstance(default, dict) and "name" in default:  # A part of the pipeline.
        return isinstance(value, str) or (isinstance(value, dict) and "name" in value)
    number = isinstance(default, float) and isinstance(value, int)
    return default is None or number or isinstance(value, type(default))
