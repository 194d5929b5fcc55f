"""XML files from strangers: a tree with line numbers, and nothing that unfolds or fetches."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

from avsec_gym.errors import DataError
from avsec_gym.storage.text_files import read_text

_DEEPEST = 16
_LARGEST = 256 * 2**20
"""Bytes of a file that `read_plain_xml` takes."""
_DISTRUST = "Do not trust this file; fetch it again from where it was published."
_AGAIN = "The file may be cut off or damaged; fetch it again."


@dataclass(frozen=True)
class Element:
    """An element with its own text and its children."""

    name: str
    line: int
    path: str | Path
    children: list[Element] = field(default_factory=list)
    parts: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """Its text, without the space around it."""
        return "".join(self.parts).strip()

    def all(self, name: str) -> list[Element]:
        """The children of a name."""
        return [child for child in self.children if child.name == name]

    def find(self, name: str) -> Element | None:
        """The only child of a name, None without any.

        Raises:
            DataError: There are several.
        """
        found = self.all(name)
        if len(found) > 1:
            found[1].refuse(f"There is a second <{name}> in <{self.name}>.")
        return found[0] if found else None

    def child(self, name: str) -> Element:
        """The only child of a name.

        Raises:
            DataError: There is none, or there are several.
        """
        return self.find(name) or self.refuse(f"<{self.name}> lacks a <{name}>.")

    def number(self, name: str, default: float | None = None) -> float:
        """The number in the only child of a name.

        Raises:
            DataError: It lacks and there is no default, or it is no finite number up to a million.
        """
        child = self.find(name)
        if child is None and default is not None:
            return default
        child = child or self.child(name)
        try:
            value = float(child.text)
        except ValueError:
            value = float("nan")
        if not abs(value) <= 1e6:  # Also true for NaN.
            child.refuse(f"<{name}> holds {child.text[:40]!r}, no number or too large to be true.")
        return value

    def refuse(self, problem: str) -> NoReturn:
        """Raise an error that names this element.

        Raises:
            DataError: Always.
        """
        raise DataError(problem, path=self.path, line=self.line, remedy=_AGAIN)


def read_xml(path: str | Path) -> Element:
    """The outermost element of a file.

    Raises:
        DataError: Missing, too large, not UTF-8, no XML, nested too deeply, or with entities of
            its own, which a small file can unfold to fill the memory.
    """
    text = read_text(path)
    outside = Element("file", 1, path)
    stack = [outside]
    parser = expat.ParserCreate()

    def start(name: str, _: dict[str, str]) -> None:
        if len(stack) > _DEEPEST:
            stack[-1].refuse("The elements are nested too deeply.")
        element = Element(name, parser.CurrentLineNumber, path)
        stack[-1].children.append(element)
        stack.append(element)

    def end(_: str) -> None:
        stack.pop()

    def characters(data: str) -> None:
        stack[-1].parts.append(data)

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.CharacterDataHandler = characters
    _parse(parser, text, path)
    return outside.children[0]


def read_plain_xml(path: str | Path) -> ElementTree.Element:
    """The outermost element of a larger file whose format knows no document type.

    Raises:
        DataError: Missing, too large, not UTF-8, no XML, or with declarations of its own.
    """
    text = read_text(path, most=_LARGEST)
    parser = expat.ParserCreate()

    def doctype(*_: object) -> None:
        raise DataError(
            "The XML declares a document type, which such files never do.",
            path=path,
            line=parser.CurrentLineNumber,
            remedy=_DISTRUST,
        )

    parser.StartDoctypeDeclHandler = doctype
    _parse(parser, text, path)
    return ElementTree.fromstring(text)


def _parse(parser: expat.XMLParserType, text: str, path: str | Path) -> None:
    def entity(*_: object) -> None:
        raise DataError(
            "The XML declares an entity, which such files never do.",
            path=path,
            line=parser.CurrentLineNumber,
            remedy=_DISTRUST,
        )

    parser.EntityDeclHandler = entity
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise DataError(
            f"This is no well-formed XML ({error}).", path=path, line=error.lineno, remedy=_AGAIN
        ) from error
