"""The README in the metadata of the package, where links to files of the repository would lead nowhere."""

import re
from pathlib import Path

from setuptools import setup

RELATIVE_LINK = re.compile(r"\[([^\]]+)\]\((?!https?://|#)([^)]+)\)")
RELATIVE_IMAGE = re.compile(r"<img src=\"(?!https?://)[^>]*> ?")
NOTE = "*Files in parentheses, such as `docs/environments.md`, are in the source distribution.*\n\n"


def standalone_readme(text: str) -> str:
    """Replace links to files by their names, leave out images, and say where the files are."""
    without_images = RELATIVE_IMAGE.sub("", text)
    introduction, heading, rest = RELATIVE_LINK.sub(r"\1 (`\2`)", without_images).partition("\n## ")
    return f"{introduction}\n{NOTE}{heading[1:]}{rest}"


setup(
    long_description=standalone_readme(Path("README.md").read_text(encoding="utf-8")),
    long_description_content_type="text/markdown",
)
