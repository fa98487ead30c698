"""The README in the metadata of the package, and compiled libraries in wheels for one kind of machine.

Links to files of the repository would lead nowhere in the metadata. `make wheel` names a folder of libraries
in the environment variable PRP_GYM_LIBRARIES; without it there are none, and the wheel is for every machine.
"""

import os
import re
import shutil
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

RELATIVE_LINK = re.compile(r"\[([^\]]+)\]\((?!https?://|#)([^)]+)\)")
RELATIVE_IMAGE = re.compile(r"<img src=\"(?!https?://)[^>]*> ?")
NOTE = "*Files in parentheses, such as `docs/environments.md`, are in the source distribution.*\n\n"


def standalone_readme(text: str) -> str:
    """Replace links to files by their names, leave out images, and say where the files are."""
    without_images = RELATIVE_IMAGE.sub("", text)
    introduction, heading, rest = RELATIVE_LINK.sub(r"\1 (`\2`)", without_images).partition("\n## ")
    return f"{introduction}\n{NOTE}{heading[1:]}{rest}"


LIBRARIES = os.environ.get("PRP_GYM_LIBRARIES")


class PlatformDistribution(Distribution):
    """A distribution for one kind of machine."""

    def has_ext_modules(self) -> bool:
        """See `Distribution`: libraries are no extension modules, but no more portable."""
        return True


class BuildWithLibraries(build_py):
    """Adds the libraries to the files of the package."""

    def run(self) -> None:
        """See `build_py`."""
        super().run()
        libraries = sorted(Path(str(LIBRARIES)).glob("*.so"))
        if not libraries:
            raise SystemExit(
                f"PRP_GYM_LIBRARIES={LIBRARIES}: no libraries (*.so) in this folder; see `make wheel`."
            )
        folder = Path(self.build_lib) / "prp_gym" / "symbolic" / "prebuilt"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        for library in libraries:
            shutil.copyfile(library, folder / library.name)


class WheelOfAnyPython(bdist_wheel):
    """A wheel whose libraries do not depend on the version of Python."""

    def get_tag(self) -> tuple[str, str, str]:
        """See `bdist_wheel`."""
        return "py3", "none", super().get_tag()[2]


WITH_LIBRARIES = {
    "distclass": PlatformDistribution,
    "cmdclass": {"build_py": BuildWithLibraries, "bdist_wheel": WheelOfAnyPython},
}

setup(
    long_description=standalone_readme(Path("README.md").read_text(encoding="utf-8")),
    long_description_content_type="text/markdown",
    **(WITH_LIBRARIES if LIBRARIES else {}),
)
