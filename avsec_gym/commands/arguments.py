"""From words on the command line to a command: its dataclass states which options there are.

tyro does the parsing.  What is added here is what people read: an unknown option or choice is
answered with the one that it may have meant, and the help states of each option what can be typed,
no more: ``--limit INT`` for what may also be left out, no default where that is nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import tyro
from tyro.constructors import (
    ConstructorRegistry,
    PrimitiveConstructorSpec,
    StructConstructorSpec,
    StructFieldSpec,
    StructTypeInfo,
)

from avsec_gym.errors import ConfigurationError
from avsec_gym.suggestions import did_you_mean, unknown_name

Command = TypeVar("Command")

_HELP = ("-h", "--help")


@dataclass(frozen=True)
class Option:
    """One that a command takes.

    Args:
        flag: The flag as it is typed, such as ``--no-lidar``.
        choices: The words that the option takes, where that is one of a few words.
    """

    flag: str
    choices: tuple[str, ...] = ()


def parse(command: type[Command], words: Sequence[str], program: str) -> Command:
    """The command that the words spell.

    Args:
        command: A frozen dataclass.
        words: What was typed after its name.
        program: What was typed before, such as ``avsec world make``.

    Raises:
        ConfigurationError: There is no such option, or no such choice of one.
        SystemExit: The help was asked for (code 0), or tyro refused a word (2).
    """
    _check_options(command, words, program)
    return tyro.cli(
        command,
        prog=program,
        args=list(words),
        config=(
            tyro.conf.OmitArgPrefixes,
            tyro.conf.FlagCreatePairsOff,
            tyro.conf.DisallowNone,
        ),
        registry=_REGISTRY,
    )


def options(command: Any) -> list[Option]:
    """Every option of a command, those of its parts among them; no positional ones.

    Args:
        command: A dataclass, all of whose fields become options.
    """
    return [option for _, option in _walk(command)]


def _walk(command: Any) -> Iterator[tuple[str, Option]]:
    hints = get_type_hints(command, include_extras=True)
    for field in fields(command):
        annotation = hints[field.name]
        plain = _unwrapped(annotation)
        if is_dataclass(plain):
            yield from _walk(plain)
        elif tyro.conf.Positional not in _markers(annotation):
            yield field.name, Option(_flag(field.name, field.default), _choices(plain))


def _check_options(command: Any, words: Sequence[str], program: str) -> None:
    """Refuse an option that the command does not have, and words that are no value of any.

    Raises:
        ConfigurationError: There is one; it names what it may have meant, or which option it is of.
    """
    known = [*(option.flag for option in options(command)), "--help"]
    last = ""
    for word in words:
        flag, sign, value = word.partition("=")
        flag = flag.replace("_", "-")
        if flag in _HELP:
            return
        own = flag if flag in known else ""
        _check_value(value if own and sign else word, own or last, program)
        last = own or last
        if word.startswith("--") and len(word) > 2 and flag not in known:
            # Without dashes, which all options have in common; they are put back.
            nearest = did_you_mean(flag[2:], [flag[2:] for flag in known]).replace('"', '"--', 1)
            problem = f"{program} has no option {flag}."
            remedy = f"`{program} --help` lists all."
            raise ConfigurationError(" ".join(filter(None, (problem, nearest, remedy))))


def _check_value(value: str, flag: str, program: str) -> None:
    """Refuse a value that no option takes: to the system, an empty path is the folder it is in.

    Raises:
        ConfigurationError: It is one; the message names the option before it.
    """
    where = f"{program} {flag}:" if flag else f"{program}:"
    if not value:
        raise ConfigurationError(f"{where} a path or value is empty; name one, or leave it out")
    if "\0" in value:
        raise ConfigurationError(f"{where} a path or value holds a NUL, as no name can")


_REGISTRY = ConstructorRegistry()
_ASKING: list[Any] = []
"""The dataclass whose fields tyro is being asked for."""


@_REGISTRY.struct_rule
def _plain_fields(info: StructTypeInfo) -> StructConstructorSpec | None:
    """The fields that tyro finds in a dataclass, to be shown as people type them."""
    if not is_dataclass(info.type) or info.type in _ASKING:
        return None
    _ASKING.append(info.type)
    try:
        spec = ConstructorRegistry.get_struct_spec(info)
    finally:
        _ASKING.pop()
    if not isinstance(spec, StructConstructorSpec):
        return None
    return replace(spec, fields=tuple(map(_plain_field, spec.fields)))


def _plain_field(field: StructFieldSpec) -> StructFieldSpec:
    annotation: Any = field.type
    plain = _unwrapped(annotation)
    if is_dataclass(plain):
        return field
    positional = tyro.conf.Positional in _markers(annotation)
    several = get_origin(plain) is tuple
    shown: dict[str, Any] = {}
    # A flag is off, and an option without a value is absent: that needs no saying.
    if field.default in (None, ()) or isinstance(field.default, bool):
        shown["help_behavior_hint"] = ""
    if positional:
        name = field.name.upper()
        shown["metavar"] = f"{name} [{name} ...]" if several else name
        if several and field.default != ():
            shown["help_behavior_hint"] = "(required)"
    if choices := _choices(plain):
        shown["metavar"] = "{" + ",".join(choices) + "}"
        name = field.name if positional else _flag(field.name, field.default)
        annotation = Annotated[annotation, _one_of(choices, name)]
    annotation = Annotated[annotation, tyro.conf.arg(**shown)]
    return replace(field, type=annotation, helptext=_in_paragraphs(field.helptext))


def _in_paragraphs(text: str | Callable[[], str | None] | None) -> str | None:
    """Without the line breaks of the source, which are none of the page."""
    text = text() if callable(text) else text
    if text is None:
        return None
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in text.split("\n\n"))


def _one_of(choices: tuple[str, ...], name: str) -> PrimitiveConstructorSpec[str]:
    """How one of a few words is read."""

    def read(words: list[str]) -> str:
        if words[0] not in choices:
            raise ConfigurationError(
                unknown_name(f"{name} cannot be {words[0]}", words[0], choices)
            )
        return words[0]

    return PrimitiveConstructorSpec(
        nargs=1,
        metavar=name,
        instance_from_str=read,
        is_instance=lambda value: value in choices,
        str_from_instance=lambda value: [str(value)],
    )


def _flag(name: str, default: Any) -> str:
    dashed = name.replace("_", "-")
    return f"--no-{dashed}" if default is True else f"--{dashed}"


def _choices(plain: Any) -> tuple[str, ...]:
    return get_args(plain) if get_origin(plain) is Literal else ()


def _unwrapped(annotation: Any) -> Any:
    """Without what is noted beside it, and without None."""
    if get_origin(annotation) is Annotated:
        return _unwrapped(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        others = [member for member in get_args(annotation) if member is not NoneType]
        return _unwrapped(others[0]) if len(others) == 1 else annotation
    return annotation


def _markers(annotation: Any) -> tuple[Any, ...]:
    return get_args(annotation)[1:] if get_origin(annotation) is Annotated else ()
