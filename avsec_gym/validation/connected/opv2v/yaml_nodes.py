"""A few numbers out of a YAML file: nothing of it is constructed, and nothing else is looked at.

OPV2V's files hold the camera parameters and planned paths, too, and some that were written by other
programs name Python classes. The tree of nodes is taken as it stands, so that no tag has an effect.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import read_text

if TYPE_CHECKING:
    import yaml

MAX_YAML_BYTES = 4 * 2**20
"""OPV2V's files have 20 to 100 kB."""
_REMEDY = "Fetch the file again."


class YamlMapping:
    """A mapping in a file, whose entries are read one by one, each by what it must be.

    Args:
        path: The file, for errors.
        node: The mapping's YAML node.

    Raises:
        DataError: The node is no mapping, or has a key twice.
    """

    def __init__(self, path: str | Path, node: yaml.Node) -> None:
        self._path = path
        self._node = node
        if node.id != "mapping":
            raise self._error(node, "This is no mapping of names to values.")
        self._entries: dict[str, yaml.Node] = {}
        for key, value in node.value:
            if key.id != "scalar" or key.value in self._entries:
                raise self._error(key, "A key stands twice, or is none.")
            self._entries[key.value] = value

    def __contains__(self, key: str) -> bool:
        return key in self._entries

    def number(self, key: str, most: float) -> float:
        """A finite number whose size is at most `most`."""
        return self._number(self._entry(key), most)

    def numbers(self, key: str, count: int, most: float) -> tuple[float, ...]:
        """A list of so many finite numbers, each at most `most` in size."""
        node = self._entry(key)
        if node.id != "sequence" or len(node.value) != count:
            raise self._error(node, f"{key} is a list of {count} numbers.")
        return tuple(self._number(each, most) for each in node.value)

    def mappings(self, key: str, most: int) -> Iterator[tuple[str, YamlMapping]]:
        """The entries of a mapping of mappings, at most so many; an empty list stands for none."""
        node = self._entry(key)
        if node.id == "sequence" and not node.value:
            return
        inner = YamlMapping(self._path, node)
        if len(inner._entries) > most:
            raise self._error(node, f"{key} has more than {most} entries.")
        for name, value in inner._entries.items():
            yield name, YamlMapping(self._path, value)

    def broken(self, key: str, problem: str) -> DataError:
        """The error of an entry that cannot be."""
        return self._error(self._entry(key), problem)

    def _entry(self, key: str) -> yaml.Node:
        if key not in self._entries:
            raise self._error(self._node, f"There is no {key}.")
        return self._entries[key]

    def _number(self, node: yaml.Node, most: float) -> float:
        try:
            if node.id != "scalar" or len(node.value) > 40:
                raise ValueError
            value = float(node.value)
        except ValueError:
            raise self._error(node, "This is no number.") from None
        if not math.isfinite(value) or abs(value) > most:
            raise self._error(node, f"A number is at most {most:g} here, not {value:g}.")
        return value

    def _error(self, node: yaml.Node, problem: str) -> DataError:
        return DataError(problem, path=self._path, line=node.start_mark.line + 1, remedy=_REMEDY)


def read_yaml_mapping(path: str | Path) -> YamlMapping:
    """The mapping that a YAML file is.

    Args:
        path: The file, of one document.

    Raises:
        ConfigurationError: PyYAML is not installed.
        DataError: The file cannot be read, is larger than `MAX_YAML_BYTES`, or no mapping.
    """
    try:
        import yaml
    except ImportError as error:
        raise ConfigurationError(
            "OPV2V's yaml files are read with PyYAML: pip install 'avsec-gym[opv2v]'"
        ) from error
    text = read_text(path, most=MAX_YAML_BYTES)
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    # ValueError and OverflowError: an escape that stands for no character.
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        mark = getattr(error, "problem_mark", None)
        raise DataError(
            f"The file is no YAML ({getattr(error, 'problem', None) or 'of one document'}).",
            path=path,
            line=None if mark is None else mark.line + 1,
            remedy=_REMEDY,
        ) from error
    except RecursionError as error:
        raise DataError("The file is nested too deeply.", path=path, remedy=_REMEDY) from error
    if node is None:
        raise DataError("The file is empty.", path=path, remedy=_REMEDY)
    return YamlMapping(path, node)
