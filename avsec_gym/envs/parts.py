"""The parts of the pipeline that an environment's agent does not play, checked and made.

An environment is the pipeline with one part taken out, which the agent plays.  The others are
keyword arguments with the same names, defaults and meaning in every environment: names, JSON-able
dictionaries or live objects.  `takes_parts` states which of them an environment refuses, and why.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from inspect import Parameter, Signature, signature
from types import MappingProxyType
from typing import Any, TypeVar

from avsec_gym.argument_checks import keep_checked, number, one_of
from avsec_gym.attacks.attacked_detector import attack_kind
from avsec_gym.envs.game_validator import check_validator, is_measured, validator_and_played
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.errors import ConfigurationError
from avsec_gym.image_only import check_detector
from avsec_gym.pipeline import Pipeline
from avsec_gym.registry import Kind, check, make
from avsec_gym.scenario.frame_scenes import FrameScenes, frame_scenes_of
from avsec_gym.scenario.roads import ROADS, THESIS
from avsec_gym.scenario.scene import Motion
from avsec_gym.suggestions import unknown_name
from avsec_gym.validation.response import Response

_Environment = TypeVar("_Environment")
_KNOWS_NOTHING = (
    "an attack by gradient needs a detector that it knows: name the judged one, such as "
    'detector="dsgn", or another one, such as '
    'attack={"name": "transferred", "attack": "thesis_pgd", "of": "dsgn"}'
)


@dataclass(frozen=True, eq=False)
class Parts:
    """What an environment is made of, beside its agent.

    What cannot work is refused at once.  A bare name is looked up, and its part is made when it is
    asked for, as networks take seconds to load; a part with arguments is made at once, since only
    that shows whether they fit, and so is an attack.  Nothing is measured, and no scene is read.

    Args:
        scenarios: The scenes: a default suite of the procedural world (``mixed``, ``street``,
            ``highway``, ``mixed_contested``), made in the cache on first use; a folder in KITTI's
            object layout; or a dictionary of arguments of `frame_scenes`.
        detector: The detector O, which finds objects in the sensor data.  Where the agent does, it
            is the detector that is judged: the attack knows it.
        attack: The attack, which tampers with the sensors or with what detectors see of them; None:
            no attack.
        classifier: The classifier C, which finds the objects that move; None: `motion` states it.
        selector: The selector S, which finds the road's type; None: the scene's own type holds.
        planner: The planner M, which plans the trajectory among the detected objects.
        validator: The validator, which looks for attacks on the LiDAR and the cameras 3 and 2,
            before O; None: there is none.  ``thresholds`` are the thesis' algorithms on four shares
            of the sensors, with ``"criterion": "error"`` on its E alone.  Without a table
            (``"thresholds": "FILE"``, as `avsec validate` writes it) they are measured at the first
            reset, see `validator_and_played`.
        clean: Scenes without an attack that thresholds are measured on, the first 50 of them, named
            as `scenarios` are; None: the first half of the scenarios, ten or more.  They are not
            played.  Refused where no threshold is measured.
        response: What the car does at an alarm: ``stop``, ``drop`` (it drives on without the
            compromised sensors), ``repair`` (with their data repaired by the others); None: it
            drives on as if there were none.
        motion: What the planner takes as moving where there is no classifier: ``static``, nothing;
            ``truth``: it knows how the real objects behind the boxes move.
        score_threshold: Detections of a lower score are not planned on, in [0, 1].
        road: What the car drives on: ``thesis``, the authors' straight lanes; ``own``, the road
            that a procedural scene lies on, with the intentions that it has lanes for.  Scenes of
            real frames have none.
        agent: The part that the agent plays.

    Raises:
        ConfigurationError: A name is unknown, an argument of a part does not fit, a number is out
            of range, or an attack by gradient knows no detector.
        DataError: A folder of scenes or a file of weights is missing or broken.
    """

    scenarios: Any = "mixed"
    detector: Any = "dsgn"
    attack: Any = None
    classifier: Any = None
    selector: Any = None
    planner: Any = "astar"
    validator: Any = None
    clean: Any = None
    response: Response | str | None = "stop"
    motion: Motion | str = "static"
    score_threshold: float = 0.3
    road: str = THESIS
    agent: Kind = Kind.ATTACK

    def __post_init__(self) -> None:
        checked: dict[str, Any] = {
            "score_threshold": number("score_threshold", self.score_threshold, 0.0, 1.0),
            "motion": _known_motion(self.motion, self.classifier),
            "planner": _checked(Kind.PLANNER, self.planner),
            "road": one_of("road", self.road, ROADS),
        }
        check_validator(self.validator, self.clean)
        if self.validator is not None and not is_measured(self.validator):
            checked["validator"] = _checked(Kind.VALIDATOR, self.validator)
        if self.response is not None:
            checked["response"] = Response.named(self.response)
        for kind in (Kind.CLASSIFIER, Kind.SELECTOR):
            if getattr(self, kind) is not None:
                checked[kind] = _checked(kind, getattr(self, kind))
        if self.agent != Kind.DETECTOR or self.detector is not None:
            checked["detector"] = _checked(Kind.DETECTOR, self.detector)
            check_detector(checked["detector"])
        if self.attack is not None:
            checked["attack"] = _made(_checked_attack(self.attack), self.attack)
            if self.detector is None and getattr(checked["attack"], "needs_gradient", False):
                raise ConfigurationError(_KNOWS_NOTHING)
        keep_checked(self, checked)

    def car(self, agent: Any = None) -> tuple[Pipeline, FrameScenes]:
        """The whole pipeline, and the scenes that are played: those no threshold was measured on.

        Args:
            agent: What stands for the agent, where it plays the detector or the validator.  An
                attack then knows the detector that was named.

        Raises:
            ConfigurationError: Arguments of a part do not fit, no scene is left, or the scenes
                lack a sensor that is judged, or a road of their own that is asked for.
            DataError: A file, such as the detector's weights, is missing or broken.
        """
        clean = None if self.clean is None else frame_scenes_of(self.clean)
        scenes = frame_scenes_of(self.scenarios, self.road)
        with one_thread():  # As in `_made`.
            validator, scenes = validator_and_played(self.validator, scenes, clean)
            judged = self.agent == Kind.DETECTOR
            pipeline = Pipeline(
                agent if judged else self.detector,
                attack=self.attack,
                classifier=self.classifier,
                selector=self.selector,
                planner=self.planner,
                motion=Motion.named(self.motion),
                score_threshold=self.score_threshold,
                validator=agent if self.agent == Kind.VALIDATOR else validator,
                response=self.response,
                victim=self.detector if judged else None,
            )
        return pipeline, scenes


@dataclass(frozen=True)
class TakenParts:
    """Which parts an environment takes.

    Args:
        agent: The part that the agent plays.
        refused: Parts that have no meaning there, with the reason.
        defaults: Defaults other than those of `Parts`.
        renamed: Names of former arguments, with what to give now.
    """

    agent: Kind
    refused: Mapping[str, str] = field(default_factory=dict)
    defaults: Mapping[str, Any] = field(default_factory=dict)
    renamed: Mapping[str, str] = field(default_factory=dict)

    @property
    def parameters(self) -> list[Parameter]:
        """The parameters as a signature shows them."""
        return [
            Parameter(
                each.name,
                Parameter.KEYWORD_ONLY,
                default=self.defaults.get(each.name, each.default),
                annotation=each.type,
            )
            for each in fields(Parts)
            if each.name != "agent" and each.name not in self.refused
        ]


def takes_parts(
    agent: Kind,
    *,
    refused: Mapping[str, str] = MappingProxyType({}),
    renamed: Mapping[str, str] = MappingProxyType({}),
    **defaults: Any,
) -> Callable[[type[_Environment]], type[_Environment]]:
    """Let an environment, whose constructor ends in ``**parts``, show the parts that it takes.

    Args:
        agent: The part that the agent plays.
        refused: Parts that have no meaning there, with the reason.
        renamed: Names of former arguments, with what to give now.
        defaults: Defaults other than those of `Parts`; a table in docs/environments.md lists them.
    """
    taken = TakenParts(agent, refused, defaults, renamed)

    def decorate(environment: type[_Environment]) -> type[_Environment]:
        own = signature(environment.__init__).parameters.values()
        shown = [each for each in own if each.kind != Parameter.VAR_KEYWORD][1:]
        shown = [each.replace(kind=Parameter.KEYWORD_ONLY) for each in shown]
        environment.taken_parts = taken  # type: ignore[attr-defined]
        environment.__signature__ = Signature([*taken.parameters, *shown])  # type: ignore[attr-defined]
        return environment

    return decorate


def parts_of(environment: Any, given: Mapping[str, Any]) -> Parts:
    """The parts that a user gave to an environment, and the defaults of all others.

    Args:
        environment: The environment; `takes_parts` states what it takes.
        given: The keyword arguments that are none of its own.

    Raises:
        ConfigurationError: It has no such argument, or see `Parts`.
    """
    taken: TakenParts = environment.taken_parts
    for name in given:
        if name in taken.refused:
            raise ConfigurationError(
                f"{environment.title} takes no {name!r}: {taken.refused[name]}; leave it out"
            )
        if name in taken.renamed:
            raise ConfigurationError(
                f"{environment.title} has no argument {name!r} any more: {taken.renamed[name]}"
            )
        if name not in {each.name for each in taken.parameters}:
            problem = f"{environment.title} has no argument {name!r}"
            known = signature(type(environment)).parameters
            raise ConfigurationError(unknown_name(problem, name, known))
    return Parts(**{**taken.defaults, **given}, agent=taken.agent)


def _known_motion(motion: Any, classifier: Any) -> Motion:
    return Motion.without_classifier(motion) if classifier is None else Motion.named(motion)


def _checked_attack(what: Any) -> Kind:
    """Whether it is an optical attack or another one.

    Raises:
        ConfigurationError: Nothing has that name, or its arguments have other names.
    """
    kind = attack_kind(what)
    check(kind, what)
    return kind


def _checked(kind: Kind, what: Any) -> Any:
    """A part that has arguments, made; a bare name or a live part as it is."""
    check(kind, what)
    has_arguments = isinstance(what, Mapping) and set(what) != {"name"}
    return _made(kind, what) if has_arguments else what


def _made(kind: Kind, what: Any) -> Any:
    """The part, which can do what parts of its kind do.

    Raises:
        ConfigurationError: The arguments do not fit, or what was made of them is no such part.
    """
    with one_thread():  # A forked process would wait forever for the threads of its parent.
        part = make(kind, what)
    check(kind, part)
    return part
