"""Names for the parts of the pipeline, open to third parties.

A package adds its own by an entry point of the group ``avsec_gym.plugins`` that names a function
without arguments, which calls `register`.  Wherever this project takes one of these parts, it takes
a name, a dictionary of a name and its arguments, or the object itself.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module, metadata
from typing import Any

from avsec_gym.argument_checks import shown
from avsec_gym.built_in_parts import BUILT_IN, METHODS, NO_ATTACKS, RESERVED, Kind
from avsec_gym.errors import ConfigurationError
from avsec_gym.factory_arguments import check_arguments, named_parameters
from avsec_gym.suggestions import unknown_name

__all__ = [
    "GROUP",
    "Kind",
    "adopt",
    "check",
    "kind_of",
    "made_part",
    "make",
    "names",
    "refuse",
    "register",
    "registered_by_hand",
]

_LOG = logging.getLogger(__name__)
GROUP = "avsec_gym.plugins"
"""Entry points by which packages add parts."""
_NAME = re.compile(r"\w[\w.+-]{0,99}")


_REGISTERED: dict[tuple[Kind, str], Callable[..., Any]] = {}
_PLUGINS_LOADED = False
_BY_PLUGINS: set[tuple[Kind, str]] = set()


def register(kind: Kind | str, name: str, factory: Callable[..., Any]) -> None:
    """Give a factory a name.

    Args:
        kind: One of `Kind`.
        name: How users ask for it: letters, digits, ``_``, ``.``, ``+`` and ``-``.
        factory: The function or class that makes the object from keyword arguments.

    Raises:
        ConfigurationError: The name is taken, means something else in commands, or is none that can
            be typed; or the kind is unknown.
    """
    key = (_kind(kind), name)
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise ConfigurationError(
            f"a {key[0]} cannot be named {shown(name)}: give it a name of letters, digits, '_',"
            " '.', '+' and '-', such as 'mine'; else commands see JSON, a list, a path or an option"
        )
    if key in RESERVED:
        raise ConfigurationError(
            f"a {key[0]} cannot be named {name!r}: `--{key[0]} {name}` asks for every {key[0]} of"
            " the package; choose another name"
        )
    ambiguous = key[0] == Kind.ATTACK and name in NO_ATTACKS
    if key in BUILT_IN or key in _REGISTERED or ambiguous:
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
        if arguments or not BUILT_IN.get((kind, name), ("", {}))[1]:
            _check_names(kind, name, arguments)
    elif not hasattr(what, METHODS[kind]):
        raise ConfigurationError(
            f"{kind.words} is a name, a dictionary of a name and arguments, or an object that has "
            f"{METHODS[kind]}(), got {shown(what)}"
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
    if not isinstance(name, str) or (Kind.ATTACK in kinds and name in NO_ATTACKS):
        return kinds[0]
    found = next((kind for kind in kinds if name in names(kind)), None)
    if found is None:
        raise _unknown(name, kinds)
    return found


def names(kind: Kind | str) -> list[str]:
    """Every registered name of a kind, sorted."""
    kind = _kind(kind)
    _load_plugins()
    return sorted(name for known, name in [*BUILT_IN, *_REGISTERED] if known == kind)


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
    if kind == Kind.ATTACK and name in NO_ATTACKS:
        raise ConfigurationError(NO_ATTACKS[name])
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
    path, defaults = BUILT_IN[kind, name]
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
    for each in named_parameters(factory) or ():
        if each.default is each.empty and each.name not in {**defaults, **arguments}:
            raise ConfigurationError(
                f"the {kind} {name!r} needs the argument {each.name!r}{where}: give a dictionary "
                f'such as {{"name": "{name}", "{each.name}": ...}}'
            )


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
