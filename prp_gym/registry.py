"""`Registry`: declarations by name; the suite's own are found in their folder, others are registered."""

import pkgutil
import re
from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Generic, Protocol, TypeVar

from prp_gym.checks import whole
from prp_gym.errors import InvalidValueError, UnknownNameError

NOT_IN_THE_REPORT = 1000.0
"""Chapter of a declaration without a chapter in the report; it is listed after those with one."""

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]*")


class Declaration(Protocol):
    """An entry of a registry: a frozen value in the module of the code that it declares."""

    @property
    def name(self) -> str:
        """The name by which the declaration is found."""

    @property
    def chapter(self) -> float:
        """Chapter of the report, for the order of lists; `NOT_IN_THE_REPORT` without one."""

    @property
    def revision(self) -> int:
        """Revision of the declared behaviour, from 1; every change of results raises it."""


SpecT = TypeVar("SpecT", bound=Declaration)


class Registry(Mapping[str, SpecT], Generic[SpecT]):
    """Declarations of one kind by name, in the order of the report's chapters, then of registration.

    The suite's own are found by importing every module of their package when the registry is first read, so
    that a new file is enough for a new declaration.

    Args:
        kind: kind of the declarations, for messages.
        package: package whose modules hold the suite's own declarations; imported on first use.
    """

    def __init__(self, kind: str, package: str) -> None:
        self._kind = kind
        self._package = package
        self._specs: dict[str, SpecT] = {}
        self._complete = False

    def register(self, spec: SpecT) -> SpecT:
        """Add a declaration; an equal one may be added again.

        Raises:
            InvalidValueError: a name that is taken or that cannot be a file name, or a revision below 1.
        """
        if not isinstance(spec.name, str) or not _NAME.fullmatch(spec.name):
            allowed = "a letter, then letters, digits, '_', '-' or '.'"
            raise InvalidValueError(f"name of {self._kind}", spec.name, allowed)
        whole(f"revision of {self._kind} {spec.name!r}", spec.revision, 1)
        if self._specs.setdefault(spec.name, spec) != spec:
            allowed = f"one that no other {self._kind} has"
            raise InvalidValueError(f"name of {self._kind}", spec.name, allowed)
        return spec

    def unregister(self, name: str) -> None:
        """Remove a declaration, for tests and notebooks.

        Raises:
            UnknownNameError: no declaration has this name.
        """
        self.find(name)
        del self._specs[name]

    def find(self, name: object) -> SpecT:
        """Find a declaration by its name.

        Raises:
            UnknownNameError: no declaration has this name.
        """
        specs = self._all()
        if not isinstance(name, str) or name not in specs:
            raise UnknownNameError(self._kind, name, specs)
        return specs[name]

    def __getitem__(self, name: str) -> SpecT:
        return self._all()[name]

    def __iter__(self) -> Iterator[str]:
        specs = self._all()
        return iter(
            sorted(specs, key=lambda name: specs[name].chapter)
        )  # a stable sort: ties in the order of registration

    def __len__(self) -> int:
        return len(self._all())

    def _all(self) -> dict[str, SpecT]:
        if not self._complete:
            self._complete = True  # set first, since the imported modules may read the registry
            try:
                self._import_package()
            except BaseException:
                self._complete = False
                raise
        return self._specs

    def _import_package(self) -> None:
        package = import_module(self._package)
        for name in sorted(module.name for module in pkgutil.iter_modules(package.__path__)):
            import_module(f"{self._package}.{name}")
