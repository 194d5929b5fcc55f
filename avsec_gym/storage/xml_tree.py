"""XML files from strangers: a tree with line numbers, and nothing that unfolds or fetches."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, NoReturn
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from avsec_gym.errors import DataError
from avsec_gym.storage.plain_numbers import plain_number
from avsec_gym.storage.text_files import read_text

_DEEPEST = 16
_LARGEST = 256 * 2**20
"""Bytes of a file that `read_plain_xml` takes."""
_NAMESPACE = " "
"""Stands between a namespace and the name in it."""
_DISTRUST = "Do not trust this file; fetch it again from where it was published."
_AGAIN = "The file may be cut off or damaged; fetch it again."


class Element(NamedTuple):
    """An element with its attributes, its own text and its children."""

    name: str
    line: int
    path: str | Path
    attributes: dict[str, str]
    children: list[Element]
    parts: list[str]

    @property
    def text(self) -> str:
        """Its text, without the space around it."""
        return "".join(self.parts).strip()

    @property
    def tag(self) -> str:
        """Its name in angle brackets, with its id where it has one."""
        id = self.attributes.get("id")
        return f"<{self.name}>" if id is None else f"<{self.name} id={id[:40]!r}>"

    def all(self, name: str) -> list[Element]:
        """The children of a name."""
        return [child for child in self.children if child.name == name]

    def descendants(self) -> Iterator[Element]:
        """The element itself, and all within it."""
        yield self
        for child in self.children:
            yield from child.descendants()

    def find(self, name: str) -> Element | None:
        """The only child of a name, None without any.

        Raises:
            DataError: There are several.
        """
        found = self.all(name)
        if len(found) > 1:
            found[1].refuse(f"There is a second <{name}> in {self.tag}.")
        return found[0] if found else None

    def child(self, name: str) -> Element:
        """The only child of a name.

        Raises:
            DataError: There is none, or there are several.
        """
        return self.find(name) or self.refuse(f"{self.tag} lacks a <{name}>.")

    def number(self, name: str, default: float | None = None) -> float:
        """The number in the only child of a name.

        Raises:
            DataError: It lacks and there is no default, or it is no finite number up to a million,
                or there are elements within it.
        """
        child = self.find(name)
        if child is None and default is not None:
            return default
        child = child or self.child(name)
        if child.children:
            child.refuse(f"<{name}> holds a <{child.children[0].name}> beside its number.")
        try:
            value = plain_number(child.text)
        except ValueError:
            value = float("nan")
        if not abs(value) <= 1e6:  # Also true for NaN.
            child.refuse(f"<{name}> holds {child.text[:40]!r}, no number or too large to be true.")
        return value

    def refuse(self, problem: str, remedy: str = _AGAIN) -> NoReturn:
        """Raise an error that names this element's place.

        Raises:
            DataError: Always.
        """
        raise DataError(problem, path=self.path, line=self.line, remedy=remedy)


def read_xml(path: str | Path) -> Element:
    """The outermost element of a file.

    Raises:
        DataError: Missing, too large, not UTF-8, no XML, nested too deeply, or with entities of
            its own, which a small file can unfold to fill the memory.
    """
    return _parsed(read_text(path), path, expat.ParserCreate(namespace_separator=_NAMESPACE))


def read_plain_xml(path: str | Path) -> Element:
    """The outermost element of a larger file whose format knows no document type.

    Raises:
        DataError: As of `read_xml`, or it declares a document type.
    """
    parser = expat.ParserCreate(namespace_separator=_NAMESPACE)

    def doctype(*_: object) -> None:
        raise DataError(
            "The XML declares a document type, which such files never do.",
            path=path,
            line=parser.CurrentLineNumber,
            remedy=_DISTRUST,
        )

    parser.StartDoctypeDeclHandler = doctype
    return _parsed(read_text(path, most=_LARGEST), path, parser)


def as_bytes(root: Element) -> bytes:
    """A tree as UTF-8 XML, for libraries that read XML by themselves.

    What belongs to a namespace is left out, and of text between elements the place.
    """
    pieces = ['<?xml version="1.0" encoding="UTF-8"?>']

    def add(element: Element) -> None:
        pieces.append(f"<{element.name}")
        for name, value in element.attributes.items():
            if _NAMESPACE not in name:
                pieces.append(f" {name}={quoteattr(value)}")
        pieces.append(f">{escape(element.text)}")
        for child in element.children:
            if _NAMESPACE not in child.name:
                add(child)
        pieces.append(f"</{element.name}>")

    add(root)
    return "".join(pieces).encode()


def _parsed(text: str, path: str | Path, parser: expat.XMLParserType) -> Element:
    outside = Element("file", 1, path, {}, [], [])
    stack = [outside]

    def start(name: str, attributes: dict[str, str]) -> None:
        if len(stack) > _DEEPEST:
            stack[-1].refuse("The elements are nested too deeply.")
        element = Element(name, parser.CurrentLineNumber, path, attributes, [], [])
        stack[-1].children.append(element)
        stack.append(element)

    def end(_: str) -> None:
        stack.pop()

    def characters(data: str) -> None:
        stack[-1].parts.append(data)

    def entity(*_: object) -> None:
        raise DataError(
            "The XML declares an entity, which such files never do.",
            path=path,
            line=parser.CurrentLineNumber,
            remedy=_DISTRUST,
        )

    parser.buffer_text = True
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = characters
    parser.EntityDeclHandler = entity
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise DataError(
            f"This is no well-formed XML ({error}).", path=path, line=error.lineno, remedy=_AGAIN
        ) from error
    return outside.children[0]
