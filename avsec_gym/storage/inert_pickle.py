"""Pickles read without running them: plain values as they are, everything else as a mark.

A pickle is a program for a small stack machine, whose instructions may import and call anything.
This machine imports and calls nothing.  Where a pickle names a function or a class, a `Name` comes
about; where it calls one, a function of the reader's if the reader knows that name, an `Unknown`
otherwise.  So a checkpoint can be read that holds, beside its tensors, the options and counters of
the program that wrote it.
"""

from __future__ import annotations

import pickletools
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, BinaryIO

Calls = Mapping[str, Callable[..., Any]]
"""What stands for functions, by names such as ``collections.OrderedDict``."""


@dataclass(frozen=True, eq=False)
class Name:
    """A function or class that a pickle names."""

    name: str


@dataclass(frozen=True, eq=False)
class Unknown:
    """What a pickle would have made by something that is not called."""

    name: str


class UnsoundPickle(ValueError):
    """The stream is no pickle, or breaks the rules of its machine."""


@dataclass(eq=False)
class _Machine:
    """The state between two instructions."""

    calls: Calls
    persistent: Callable[[Any], Any]
    stack: list[Any] = field(default_factory=list)
    marks: list[int] = field(default_factory=list)
    memo: dict[int, Any] = field(default_factory=dict)

    def pop(self) -> Any:
        if len(self.stack) <= (self.marks[-1] if self.marks else 0):
            raise UnsoundPickle("an instruction finds nothing on the stack")
        return self.stack.pop()

    def top(self) -> Any:
        value = self.pop()
        self.stack.append(value)
        return value

    def pop_to_mark(self) -> list[Any]:
        if not self.marks:
            raise UnsoundPickle("an instruction finds no mark on the stack")
        mark = self.marks.pop()
        values = self.stack[mark:]
        del self.stack[mark:]
        return values

    def call(self, what: Any, arguments: Any) -> Any:
        name = what.name if isinstance(what, (Name, Unknown)) else type(what).__name__
        function = self.calls.get(name) if isinstance(what, Name) else None
        if function is None or not isinstance(arguments, tuple):
            return Unknown(name)
        try:
            return function(*arguments)
        except (TypeError, ValueError) as error:
            raise UnsoundPickle(f"{name} cannot be called so ({error})") from error


def load_pickle(
    stream: BinaryIO,
    calls: Calls,
    persistent: Callable[[Any], Any] = lambda _: Unknown("elsewhere"),
) -> Any:
    """The value of the pickle that begins where a stream stands; the stream is left behind it.

    Args:
        stream: The pickle, in memory.
        calls: Functions that may be called; they raise ValueError over arguments that are none.
        persistent: Function that returns what a pickle refers to outside of itself, by the
            reference.

    Raises:
        UnsoundPickle: It is no pickle, is cut off, or breaks the rules of its machine.
    """
    machine = _Machine(calls, persistent)
    try:
        with warnings.catch_warnings():
            # Of escapes in old strings, which a damaged file may have: they are no program's.
            warnings.simplefilter("ignore", DeprecationWarning)
            for opcode, argument, _ in pickletools.genops(stream):
                if opcode.name == "STOP":
                    return machine.pop()
                _do(machine, opcode.name, argument)
    except UnsoundPickle:
        raise
    except (ValueError, TypeError, OverflowError) as error:
        # Of genops over bytes that are no instruction, and of keys that cannot be keys.
        raise UnsoundPickle(str(error)) from error
    raise UnsoundPickle("it has no end")


def unknown_parts(value: Any) -> list[str]:
    """Names of what is not plain in a value, each once; empty where all of it is."""
    found: dict[str, None] = {}
    seen: set[int] = set()
    left = [value]
    while left:
        item = left.pop()
        if isinstance(item, (Unknown, Name)):
            found[item.name] = None
        elif isinstance(item, (dict, list, tuple, set, frozenset)) and id(item) not in seen:
            seen.add(id(item))  # A container may hold itself.
            left += [*item, *item.values()] if isinstance(item, dict) else item
    return list(found)


def _do(machine: _Machine, name: str, argument: Any) -> None:
    """Do an instruction."""
    stack = machine.stack
    if name in _VALUES:
        stack.append(argument)
    elif name in _CONSTANTS:
        stack.append(_CONSTANTS[name]())
    elif name in ("PROTO", "FRAME"):
        pass
    elif name == "MARK":
        machine.marks.append(len(stack))
    elif name in ("BINPUT", "LONG_BINPUT", "PUT"):
        machine.memo[argument] = machine.top()
    elif name == "MEMOIZE":
        machine.memo[len(machine.memo)] = machine.top()
    elif name in ("BINGET", "LONG_BINGET", "GET"):
        if argument not in machine.memo:
            raise UnsoundPickle(f"it remembers no value {argument}")
        stack.append(machine.memo[argument])
    elif name in _GATHERING:
        _gather(machine, name)
    elif name in _FILLING:
        _fill(machine, name)
    elif name in _CALLING:
        _call(machine, name, argument)
    elif name == "DUP":
        stack.append(machine.top())
    elif name == "POP":
        if machine.marks and machine.marks[-1] == len(stack):
            machine.marks.pop()
        else:
            machine.pop()
    elif name == "POP_MARK":
        machine.pop_to_mark()
    else:
        raise UnsoundPickle(f"the instruction {name} is not for files")


_VALUES = frozenset(
    [
        "INT",
        "BININT",
        "BININT1",
        "BININT2",
        "LONG",
        "LONG1",
        "LONG4",
        "FLOAT",
        "BINFLOAT",
        "STRING",
        "BINSTRING",
        "SHORT_BINSTRING",
        "UNICODE",
        "BINUNICODE",
        "SHORT_BINUNICODE",
        "BINUNICODE8",
        "BINBYTES",
        "SHORT_BINBYTES",
        "BINBYTES8",
        "BYTEARRAY8",
    ]
)
_CONSTANTS: dict[str, Callable[[], Any]] = {
    "NONE": lambda: None,
    "NEWTRUE": lambda: True,
    "NEWFALSE": lambda: False,
    "EMPTY_LIST": list,
    "EMPTY_DICT": dict,
    "EMPTY_TUPLE": tuple,
    "EMPTY_SET": set,
}
_GATHERING = frozenset(["TUPLE", "TUPLE1", "TUPLE2", "TUPLE3", "LIST", "DICT", "FROZENSET"])
_FILLING = frozenset(["APPEND", "APPENDS", "SETITEM", "SETITEMS", "ADDITEMS"])
_CALLING = frozenset(
    ["GLOBAL", "STACK_GLOBAL", "REDUCE", "NEWOBJ", "NEWOBJ_EX", "INST", "OBJ", "BUILD", "BINPERSID"]
)


def _gather(machine: _Machine, name: str) -> None:
    """Make a container of values on the stack."""
    if name[-1].isdecimal():
        values = [machine.pop() for _ in range(int(name[-1]))][::-1]
    else:
        values = machine.pop_to_mark()
    if name == "DICT":
        machine.stack.append(_pairs(values))
    elif name == "FROZENSET":
        machine.stack.append(frozenset(_keys(values)))
    else:
        machine.stack.append(values if name == "LIST" else tuple(values))


def _fill(machine: _Machine, name: str) -> None:
    """Put values from the stack into the container below them; unknown ones accept anything."""
    if name == "APPEND":
        values = [machine.pop()]
    elif name == "SETITEM":
        values = [machine.pop(), machine.pop()][::-1]
    else:
        values = machine.pop_to_mark()
    container = machine.top()
    if isinstance(container, (Unknown, Name)):
        return
    if name in ("SETITEM", "SETITEMS") and isinstance(container, dict):
        container.update(_pairs(values))
    elif name in ("APPEND", "APPENDS") and isinstance(container, list):
        container.extend(values)
    elif name == "ADDITEMS" and isinstance(container, set):
        container.update(_keys(values))
    else:
        raise UnsoundPickle(f"{name} meets a {type(container).__name__}")


def _call(machine: _Machine, name: str, argument: Any) -> None:
    """Whatever would import, call or change something of Python's."""
    if name == "GLOBAL":
        machine.stack.append(Name(argument.replace(" ", ".", 1)))
    elif name == "STACK_GLOBAL":
        attribute, module = machine.pop(), machine.pop()
        machine.stack.append(Name(f"{module}.{attribute}"))
    elif name == "REDUCE":
        arguments, what = machine.pop(), machine.pop()
        machine.stack.append(machine.call(what, arguments))
    elif name == "BINPERSID":
        machine.stack.append(machine.persistent(machine.pop()))
    elif name == "BUILD":  # Attributes, of which plain values have none.
        machine.pop()
        machine.top()
    else:  # New objects of a class.
        if name in ("INST", "OBJ"):
            values = machine.pop_to_mark()
            made = Name(argument.replace(" ", ".", 1)) if name == "INST" else values[:1]
        else:
            made = [machine.pop() for _ in range(3 if name == "NEWOBJ_EX" else 2)][-1]
        machine.stack.append(Unknown(made.name if isinstance(made, Name) else "an object"))


def _pairs(values: list[Any]) -> dict[Any, Any]:
    if len(values) % 2:
        raise UnsoundPickle("a key has no value")
    return dict(zip(_keys(values[::2]), values[1::2], strict=True))


def _keys(values: list[Any]) -> list[Any]:
    """Values that can be hashed, at no depth."""
    for value in values:
        if not isinstance(value, (str, bytes, int, float, Name, Unknown, type(None))):
            raise UnsoundPickle(f"a {type(value).__name__} is a key")
    return values
