"""The evidence: what only this project's pages of results need.

``python -m studies`` lists the studies and makes them anew; ``python -m studies.NAME`` is short for
``python -m studies NAME``: what is no module of its own here is looked up in the catalogue.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from pathlib import Path
from types import ModuleType


class _StudyFinder(MetaPathFinder):
    """Finds the command ``studies.NAME``, or ``studies.NAME.__main__`` where NAME is a folder."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        package, _, name = fullname.removesuffix(".__main__").partition(".")
        if package != "studies" or not name or name.startswith("__"):
            return None
        from studies.catalogue import STUDIES

        file = Path(__file__).with_name("__main__.py")
        return spec_from_file_location(fullname, file) if name in STUDIES else None


sys.meta_path.append(_StudyFinder())
