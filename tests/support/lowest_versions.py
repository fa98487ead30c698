"""Prints the lowest declared version of every dependency, as constraints for pip.

Pinocchio is left out: each of its versions admits a single minor version of NumPy. Tests that need it are
skipped.
"""

import tomllib
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXTRAS = ("agents", "pandas", "ray", "test", "tune", "video")
LEFT_OUT = ("pin", "prp-gym")


def lowest_versions() -> Iterator[str]:
    """Requirements `name==version` for the lower bounds of the package and of the extras that tests need."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    for requirement in (*project["dependencies"], *(item for extra in EXTRAS for item in extras[extra])):
        name, bound, version = requirement.partition(">=")
        if not name.startswith(LEFT_OUT):
            if not bound:
                raise ValueError(f"{requirement!r} in pyproject.toml has no lower bound; write NAME>=VERSION")
            yield f"{name}=={version}"


if __name__ == "__main__":
    print("\n".join(lowest_versions()))
