"""The optional packages, and the extra of this package that installs each of them.

Which extra holds which package is declared in `pyproject.toml` alone, and read from the metadata of the
installed package.
"""

import re
from functools import cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from typing import Any

from prp_gym.errors import MissingPackageError

_DISTRIBUTIONS = {"yaml": "pyyaml", "PIL": "pillow"}
"""Names under which packages are installed, by the import names that differ in more than `-` and `_`."""

_OF_EXTRA = re.compile(r"(?P<name>[\w.-]+)(\[[^]]*\])?[^;]*;.*\bextra *== *['\"](?P<extra>[\w.-]+)['\"]")


def require(module: str) -> Any:
    """Import an optional package.

    Args:
        module: import name of the package, or of a module in it.

    Returns:
        the module.

    Raises:
        MissingPackageError: the package is not installed.
        ModuleNotFoundError: the package is installed, but one of its own dependencies is not.
    """
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name not in (module, package):
            raise
        raise missing(package) from None


def check(package: str) -> None:
    """Check that an optional package is installed, without importing it.

    Args:
        package: import name of the package.

    Raises:
        MissingPackageError: it is not.
    """
    if find_spec(package) is None:
        raise missing(package)


def version_of(package: str) -> str:
    """The version of an optional package.

    Args:
        package: import name of the package.

    Raises:
        MissingPackageError: it is not installed.
    """
    try:
        return version(_distribution(package))
    except PackageNotFoundError:
        raise missing(package) from None


def missing(package: str) -> MissingPackageError:
    """The error of an optional package that is not installed, with the line that installs it.

    Args:
        package: import name of the package.
    """
    return MissingPackageError(package, extra_of(package))


def extra_of(package: str) -> str:
    """The extra that installs a package; empty for a package of no extra.

    Args:
        package: import name of the package.
    """
    return _extras().get(_normal(_distribution(package)), "")


def _distribution(package: str) -> str:
    return _DISTRIBUTIONS.get(package, package)


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


@cache
def _extras() -> dict[str, str]:
    """The first extra that holds each optional package, by the normal names of the packages."""
    found: dict[str, str] = {}
    for requirement in requires("prp-gym") or []:
        if match := _OF_EXTRA.match(requirement):
            found.setdefault(_normal(match["name"]), match["extra"])
    return found
