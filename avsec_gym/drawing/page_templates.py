"""What renders parts of pages: Jinja's templates of a package, undefined names being errors."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined


@cache
def page_templates(package: str, folder: str = "templates") -> Environment:
    """The templates of a package's folder; what they are given is escaped.

    Args:
        package: The package, such as ``avsec_gym.report``.
        folder: The folder in it; empty: the package's own.
    """
    return Environment(
        loader=PackageLoader(package, folder),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
