"""`Client`: a library that uses the environments, and where the program that uses it lies."""

from dataclasses import dataclass
from pathlib import Path

_PROGRAMS = Path(__file__).parent / "programs"


@dataclass(frozen=True)
class Client:
    """A library that uses the environments through Gymnasium's interfaces alone.

    Attributes:
        name: Name of its program and of its virtual environment.
        title: Name by which the library calls itself.
        library: Requirement of the library itself, pinned; empty if it is a collection of scripts.
        packages: Further requirements, pinned where the library depends on the version.
        what: What the program does.
        limit: What of the library itself does not work, with its message; empty if there is nothing.
        alone: Whether the library is installed without its own requirements, which exclude `packages`.
    """

    name: str
    title: str
    library: str
    packages: tuple[str, ...]
    what: str
    limit: str = ""
    alone: bool = False

    @property
    def version(self) -> str:
        """Pinned version of the library; empty without one."""
        return self.library.partition("==")[2]

    @property
    def requirements(self) -> tuple[str, ...]:
        """What is installed together with the requirements of this package."""
        return self.packages if self.alone or not self.library else (self.library, *self.packages)

    @property
    def program(self) -> Path:
        """Path of the program."""
        return _PROGRAMS / f"use_{self.name}.py"
