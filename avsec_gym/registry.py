"""Names for the parts of the pipeline, open to third parties.

A package adds its own by an entry point of the group ``avsec_gym.plugins`` that names a function
without arguments, which calls `register`.  Wherever this project takes one of these parts, it takes
a name, a dictionary of a name and its arguments, or the object itself.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import StrEnum
from importlib import import_module, metadata
from inspect import Parameter, signature
from typing import Any

from avsec_gym.argument_checks import shown
from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import unknown_name

_LOG = logging.getLogger(__name__)
GROUP = "avsec_gym.plugins"
"""Entry points by which packages add parts."""


class Kind(StrEnum):
    """What can be registered."""

    DETECTOR = "detector"
    ATTACK = "attack"
    CLASSIFIER = "classifier"
    SELECTOR = "selector"
    PLANNER = "planner"
    VALIDATOR = "validator"
    OPTICAL_ATTACK = "optical_attack"
    IMAGE_DETECTOR = "image_detector"
    DRIVE_ATTACK = "drive_attack"
    CONNECTED_ATTACK = "connected_attack"
    DEFENCE = "defence"

    @property
    def words(self) -> str:
        """It with its article, for a sentence: ``an optical attack``."""
        boxes = {"detector": "a detector of 3D boxes", "image_detector": "a detector of 2D boxes"}
        article = "an" if self[0] in "aeiou" else "a"
        return boxes.get(self, f"{article} {self.replace('_', ' ')}")


_BUILT_IN = {
    (Kind.PLANNER, "astar"): ("avsec_gym.planners.planner:MotionPrimitivePlanner", {}),
    (Kind.PLANNER, "gbfs"): (
        "avsec_gym.planners.planner:MotionPrimitivePlanner",
        {"algorithm": "gbfs"},
    ),
    (Kind.DETECTOR, "dsgn"): (
        "avsec_gym.perception.detectors.dsgn.detector:DsgnDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "stereo_rcnn"): (
        "avsec_gym.perception.detectors.stereo_rcnn.detector:StereoRcnnDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "pixor"): (
        "avsec_gym.perception.detectors.pixor.detector:PixorDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "pointrcnn"): (
        "avsec_gym.perception.detectors.pointrcnn.detector:PointRcnnDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "scan_obstacles"): (
        "avsec_gym.perception.detectors.scan_obstacles:ScanObstacles",
        {},
    ),
    (Kind.IMAGE_DETECTOR, "faster_rcnn"): (
        "avsec_gym.perception.detectors.faster_rcnn.detector:FasterRcnnDetector",
        {"weights": "shipped"},
    ),
    (Kind.IMAGE_DETECTOR, "yolo"): (
        "avsec_gym.perception.detectors.yolo.detector:YoloDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "single_image"): (
        "avsec_gym.perception.detectors.single_image:SingleImage",
        {},
    ),
    (Kind.DETECTOR, "attacked"): ("avsec_gym.attacks.attacked_detector:AttackedDetector", {}),
    (Kind.DETECTOR, "defended"): (
        "avsec_gym.perception.defences.defended_detector:defended_detector",
        {},
    ),
    (Kind.DETECTOR, "oracle"): ("avsec_gym.perception.detectors.recorded:Oracle", {}),
    (Kind.DETECTOR, "replayed"): ("avsec_gym.perception.detectors.recorded:Replayed", {}),
    (Kind.DEFENCE, "jpeg"): ("avsec_gym.perception.defences.jpeg:JpegCompression", {}),
    (Kind.DEFENCE, "bit_depth"): ("avsec_gym.perception.defences.bit_depth:BitDepth", {}),
    (Kind.DEFENCE, "median_filter"): (
        "avsec_gym.perception.defences.median_filter:MedianFilter",
        {},
    ),
    (Kind.DEFENCE, "gaussian_noise"): (
        "avsec_gym.perception.defences.gaussian_noise:GaussianNoise",
        {},
    ),
    (Kind.CLASSIFIER, "small"): (
        "avsec_gym.perception.motion.classifier:MovingObjectClassifier",
        {},
    ),
    (Kind.CLASSIFIER, "vgg16"): (
        "avsec_gym.perception.motion.classifier:MovingObjectClassifier",
        {"configuration": "vgg16"},
    ),
    (Kind.SELECTOR, "small"): ("avsec_gym.perception.road_type:DrivingConstraintSelector", {}),
    (Kind.ATTACK, "thesis_pgd"): ("avsec_gym.attacks.perturbation:thesis_pgd", {}),
    (Kind.ATTACK, "fgsm"): ("avsec_gym.attacks.perturbation:fgsm", {}),
    (Kind.ATTACK, "i_fgsm"): ("avsec_gym.attacks.perturbation:i_fgsm", {}),
    (Kind.ATTACK, "mi_fgsm"): ("avsec_gym.attacks.perturbation:mi_fgsm", {}),
    (Kind.ATTACK, "projected_pgd"): ("avsec_gym.attacks.perturbation:projected_pgd", {}),
    (Kind.ATTACK, "random_noise"): ("avsec_gym.attacks.noise:RandomNoise", {}),
    (Kind.ATTACK, "patch"): ("avsec_gym.attacks.patch:PatchAttack", {}),
    (Kind.ATTACK, "random_ghosts"): ("avsec_gym.attacks.object_injection:RandomGhosts", {}),
    (Kind.ATTACK, "art"): ("avsec_gym.attacks.toolbox_attack:ToolboxAttack", {}),
    (Kind.ATTACK, "transferred"): ("avsec_gym.attacks.transferred:TransferredAttack", {}),
    (Kind.VALIDATOR, "thresholds"): (
        "avsec_gym.validation.threshold_validator:ThresholdValidator",
        {},
    ),
    (Kind.VALIDATOR, "likelihood"): (
        "avsec_gym.validation.likelihood.likelihood_validator:LikelihoodValidator",
        {},
    ),
    (Kind.OPTICAL_ATTACK, "facula"): ("avsec_gym.attacks.facula:Facula", {}),
    (Kind.OPTICAL_ATTACK, "lidar_spoofing"): ("avsec_gym.attacks.lidar_spoofing:LidarSpoofing", {}),
    (Kind.OPTICAL_ATTACK, "pasted_scan"): ("avsec_gym.attacks.pasted_scan:PastedScan", {}),
    (Kind.OPTICAL_ATTACK, "thesis"): ("avsec_gym.attacks.sensor_combination:thesis_attack", {}),
    (Kind.CONNECTED_ATTACK, "paste"): (
        "avsec_gym.validation.connected.attacks.pasted_object:PastedObject",
        {},
    ),
    (Kind.CONNECTED_ATTACK, "removal"): (
        "avsec_gym.validation.connected.attacks.removed_object:RemovedObject",
        {},
    ),
    (Kind.DRIVE_ATTACK, "ghost"): ("avsec_gym.closed_loop.attack.lasting_ghosts:LastingGhosts", {}),
    (Kind.DRIVE_ATTACK, "facula"): (
        "avsec_gym.closed_loop.attack.tracking_facula:TrackingFacula",
        {},
    ),
    (Kind.DRIVE_ATTACK, "spoofed_scan"): (
        "avsec_gym.closed_loop.attack.spoofed_scan:SpoofedScan",
        {},
    ),
}
AMBIGUOUS_ATTACKS = {
    "pgd": "in this version no attack is named 'pgd', since the name changes its meaning: the"
    " thesis' form, whose sum of steps is not projected, is 'thesis_pgd'; the projected form of"
    " Madry et al. is 'projected_pgd', and 'pgd' from the next version on"
}
"""Names that change their meaning and stand for nothing meanwhile, with what to write instead."""
_METHODS = {
    Kind.DETECTOR: "detect",
    Kind.ATTACK: "attack",
    Kind.CLASSIFIER: "classify",
    Kind.SELECTOR: "select",
    Kind.PLANNER: "plan",
    Kind.VALIDATOR: "validate",
    Kind.OPTICAL_ATTACK: "attack",
    Kind.IMAGE_DETECTOR: "detect",
    Kind.DRIVE_ATTACK: "act",
    Kind.CONNECTED_ATTACK: "attack",
    Kind.DEFENCE: "defend",
}
"""What an object of each kind can do."""
_REGISTERED: dict[tuple[Kind, str], Callable[..., Any]] = {}
_PLUGINS_LOADED = False
_BY_PLUGINS: set[tuple[Kind, str]] = set()


def register(kind: Kind | str, name: str, factory: Callable[..., Any]) -> None:
    """Give a factory a name.

    Args:
        kind: One of `Kind`.
        name: How users ask for it.
        factory: Makes the object from keyword arguments.

    Raises:
        ConfigurationError: The name is taken, or the kind is unknown.
    """
    key = (_kind(kind), name)
    ambiguous = key[0] == Kind.ATTACK and name in AMBIGUOUS_ATTACKS
    if key in _BUILT_IN or key in _REGISTERED or ambiguous:
        raise ConfigurationError(f"there is a {key[0]} named {name!r} already: choose another name")
    _REGISTERED[key] = factory


def make(kind: Kind | str, what: Any) -> Any:
    """The object that a name, a dictionary or an object stands for.

    Args:
        kind: One of `Kind`.
        what: ``"astar"``, ``{"name": "astar", "node_limit": 1000}``, or a live object, which is
            returned as it is.

    Raises:
        ConfigurationError: Nothing has that name, or the arguments do not fit.

    Example:
        >>> make("planner", {"name": "gbfs", "node_limit": 1000}).node_limit
        1000
    """
    kind = _kind(kind)
    if not isinstance(what, str | Mapping):
        return what
    name, arguments = _known(kind, what)
    _check_names(kind, name, arguments)
    factory, defaults, where = _factory(kind, name)
    try:
        return factory(**(defaults | arguments))
    except (TypeError, ValueError) as error:
        raise ConfigurationError(f"the {kind} {name!r} cannot be made: {error}{where}") from error


def made_part(argument: str, kind: Kind | str, what: Any) -> Any:
    """What `make` makes, for an argument that takes a part; it has its kind's method.

    Args:
        argument: What the user calls the argument.
        kind: One of `Kind`.
        what: What the part is, as of `make`.

    Raises:
        ConfigurationError: As of `make` and `check`, and it names the argument.
    """
    try:
        check(kind, what)
        part = make(kind, what)
        check(kind, part)
    except ConfigurationError as error:
        raise ConfigurationError(f"{argument}: {error}") from error
    return part


def check(kind: Kind | str, what: Any) -> None:
    """Refuse what `make` cannot know, and what is no such part; nothing is made.

    Arguments are compared with those that the part has.  Of a bare name of a network nothing is
    imported.

    Args:
        kind: One of `Kind`.
        what: What the part is, as of `make`.

    Raises:
        ConfigurationError: Nothing has that name, it has no such arguments or lacks one, or an
            object lacks the method that parts of this kind have.

    Example:
        >>> check("planner", {"name": "astar", "node_limit": 1000})
    """
    kind = _kind(kind)
    if isinstance(what, str | Mapping):
        name, arguments = _known(kind, what)
        # A built-in that brings arguments along works as it is.
        if arguments or not _BUILT_IN.get((kind, name), ("", {}))[1]:
            _check_names(kind, name, arguments)
    elif not hasattr(what, _METHODS[kind]):
        raise ConfigurationError(
            f"{kind.words} is a name, a dictionary of a name and arguments, or an object that has "
            f"{_METHODS[kind]}(), got {shown(what)}"
        )


def kind_of(what: Any, kinds: Sequence[Kind]) -> Kind:
    """Which of several kinds a part is of, where parts of all of them are taken.

    Args:
        what: A name, or a dictionary with one; whatever else it is counts as the first kind.
        kinds: The kinds; the first is what errors call them.

    Raises:
        ConfigurationError: It has a name that none of the kinds has.

    Example:
        >>> str(kind_of("facula", (Kind.ATTACK, Kind.OPTICAL_ATTACK)))
        'optical_attack'
    """
    name = what.get("name") if isinstance(what, Mapping) else what
    if not isinstance(name, str) or (Kind.ATTACK in kinds and name in AMBIGUOUS_ATTACKS):
        return kinds[0]
    found = next((kind for kind in kinds if name in names(kind)), None)
    if found is None:
        raise _unknown(name, kinds)
    return found


def names(kind: Kind | str) -> list[str]:
    """Every registered name of a kind, sorted."""
    kind = _kind(kind)
    _load_plugins()
    return sorted(name for known, name in [*_BUILT_IN, *_REGISTERED] if known == kind)


def registered_by_hand() -> dict[tuple[Kind, str], Callable[..., Any]]:
    """What was registered in this process, but not by plug-ins, which other processes load, too."""
    return {key: made for key, made in _REGISTERED.items() if key not in _BY_PLUGINS}


def adopt(registered: Mapping[tuple[Kind, str], Callable[..., Any]]) -> None:
    """Take over what was registered in another process."""
    _REGISTERED.update(registered)


def refuse(kind: Kind, name: str, reason: str, /, **arguments: Any) -> None:
    """A factory that stands for one which another process keeps for itself.

    Raises:
        ConfigurationError: Always.
    """
    raise ConfigurationError(f"the {kind} {name!r} is not known here: {reason}")


def _known(kind: Kind, what: str | Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """The name that is asked for, which is registered, and the arguments."""
    asked = {"name": what} if isinstance(what, str) else dict(what)
    if "name" not in asked:
        raise ConfigurationError(
            f"{kind.words} given as a dictionary needs a 'name', got {shown(what)}"
        )
    name = str(asked.pop("name"))
    if kind == Kind.ATTACK and name in AMBIGUOUS_ATTACKS:
        raise ConfigurationError(AMBIGUOUS_ATTACKS[name])
    if name not in names(kind):
        raise _unknown(name, [kind])
    return name, asked


def _unknown(name: str, kinds: Sequence[Kind]) -> ConfigurationError:
    """That a name is of none of several kinds; the first is what they are called."""
    kind, known = kinds[0], [name for kind in kinds for name in names(kind)]
    if others := [other.words for other in Kind if name in names(other)]:
        return ConfigurationError(
            f"{shown(name)} is {' and '.join(others)}, and {kind.words} is needed here. Known: "
            f"{', '.join(known)}"
        )
    problem = f"there is no {kind.replace('_', ' ')} named {shown(name)}"
    return ConfigurationError(unknown_name(problem, name, known))


def _factory(kind: Kind, name: str) -> tuple[Callable[..., Any], dict[str, Any], str]:
    """What makes a part, with which defaults, and where its arguments are described."""
    if (kind, name) in _REGISTERED:
        return _REGISTERED[kind, name], {}, ""
    path, defaults = _BUILT_IN[kind, name]
    module, attribute = path.split(":")
    where = f" (its arguments: help({module}.{attribute}))"
    return getattr(import_module(module), attribute), dict(defaults), where


def _check_names(kind: Kind, name: str, arguments: Mapping[str, Any]) -> None:
    """That a part has arguments of these names, and needs no others.

    Raises:
        ConfigurationError: It has no such argument, or lacks one.
    """
    factory, defaults, where = _factory(kind, name)
    check_arguments(f"the {kind} {name!r}", factory, arguments, where)
    for each in _parameters(factory) or ():
        if each.default is each.empty and each.name not in {**defaults, **arguments}:
            raise ConfigurationError(
                f"the {kind} {name!r} needs the argument {each.name!r}{where}: give a dictionary "
                f'such as {{"name": "{name}", "{each.name}": ...}}'
            )


def check_arguments(
    what: str, factory: Callable[..., Any], arguments: Iterable[str], where: str = ""
) -> None:
    """Refuse arguments that a factory does not have, before it is called.

    Args:
        what: What it makes, for the message.
        factory: Makes it from keyword arguments.
        arguments: The names of those that are given.
        where: Where its arguments are described, for the message.

    Raises:
        ConfigurationError: It has no such argument.

    Example:
        >>> check_arguments("a number", complex, ["image"])  # doctest: +ELLIPSIS
        Traceback (most recent call last):
        avsec_gym.errors.ConfigurationError: a number has no argument 'image'. Did you mean...
    """
    parameters = _parameters(factory)
    if parameters is None:
        return
    known = [each.name for each in parameters]
    for given in arguments:
        if given not in known:
            problem = f"{what} has no argument {given!r}{where}"
            raise ConfigurationError(unknown_name(problem, str(given), known))


def _parameters(factory: Callable[..., Any]) -> list[Parameter] | None:
    """What may be given by name; None where it cannot be known, or may be anything."""
    try:
        parameters = list(signature(factory).parameters.values())
    except (TypeError, ValueError):  # Not every callable shows its arguments.
        return None
    if any(each.kind == Parameter.VAR_KEYWORD for each in parameters):
        return None
    named = (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY)
    return [each for each in parameters if each.kind in named]


def _kind(kind: Kind | str) -> Kind:
    try:
        return Kind(kind)
    except ValueError:
        problem = f"{kind!r} is no kind of part"
        raise ConfigurationError(unknown_name(problem, str(kind), Kind)) from None


def _load_plugins() -> None:
    global _PLUGINS_LOADED
    if _PLUGINS_LOADED:
        return
    # Before loading: a plug-in may itself ask for names.
    _PLUGINS_LOADED = True
    before = set(_REGISTERED)
    for entry_point in metadata.entry_points(group=GROUP):
        try:
            entry_point.load()()
        except Exception as error:
            # A broken plug-in must not take the others, or this project, with it.
            _LOG.warning("the plug-in %s could not be loaded: %r", entry_point.name, error)
    _BY_PLUGINS.update(set(_REGISTERED) - before)
