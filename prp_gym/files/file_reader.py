"""`FileReader`: reads files in JSON, TOML and YAML as plain values."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from prp_gym.errors import DataFileError, DataTextError
from prp_gym.files.regular_file import read_bytes

SETTINGS_SIZE = 256 * 2**10
"""Largest size of a file that people write: recipes, gains, lists of agents [bytes]."""

RECORD_SIZE = 64 * 2**20
"""Largest size of a file that the package writes: results, learning curves, journals [bytes]."""

_BYTE_ORDER = "\ufeff"


@dataclass(frozen=True)
class FileReader:
    """Reader of files of one kind; nothing in them is imported or run.

    Attributes:
        largest: largest size of a file [bytes].
        error: class of the error that is raised about a file.
    """

    largest: int = SETTINGS_SIZE
    error: type[DataFileError] = DataFileError

    def read_bytes(self, path: Path) -> bytes:
        """The content of a regular file.

        Raises:
            DataFileError: a file that cannot be read, is not a regular one, or is too large.
        """
        return read_bytes(path, self.largest, self.error)

    def read_text(self, path: Path) -> str:
        """The text of a regular file in UTF-8.

        Raises:
            DataFileError: a file that cannot be read, or that holds no text in UTF-8.
        """
        return self.decode(path, self.read_bytes(path))

    def read_json(self, path: Path) -> Any:
        """The value that a JSON file holds; see `parse_json`.

        Raises:
            DataFileError: a file that cannot be read, or that is not strict JSON.
        """
        return self.parse_json(path, self.read_bytes(path))

    def read_toml(self, path: Path) -> dict[str, Any]:
        """The table that a TOML file holds; see `parse_toml`.

        Raises:
            DataFileError: a file that cannot be read, or that is not plain TOML.
        """
        return self.parse_toml(path, self.read_text(path))

    def read_yaml(self, path: Path) -> Any:
        """The value that a YAML file holds; see `parse_yaml`.

        Raises:
            DataFileError: a file that cannot be read, or that is not plain YAML.
            MissingPackageError: PyYAML is not installed.
        """
        return self.parse_yaml(path, self.read_text(path))

    def parse_json(self, path: Path, content: bytes) -> Any:
        """The value of a JSON file whose content has been read.

        Args:
            path: path of the file, for messages.
            content: content of the file.

        Raises:
            DataFileError: content that is not strict JSON.
        """
        from prp_gym.files.json_text import parse_json  # a file needs one of the three

        return self._parsed(path, self.decode(path, content), parse_json)

    def parse_toml(self, path: Path, text: str) -> dict[str, Any]:
        """The table of a TOML file whose text has been read.

        Args:
            path: path of the file, for messages.
            text: text of the file.

        Raises:
            DataFileError: text that is not plain TOML.
        """
        from prp_gym.files.toml_text import parse_toml

        table: dict[str, Any] = self._parsed(path, text, parse_toml)
        return table

    def parse_yaml(self, path: Path, text: str) -> Any:
        """The value of a YAML file whose text has been read.

        Args:
            path: path of the file, for messages.
            text: text of the file.

        Raises:
            DataFileError: text that is not plain YAML.
            MissingPackageError: PyYAML is not installed.
        """
        from prp_gym.files.yaml_text import parse_yaml

        return self._parsed(path, text, parse_yaml)

    def decode(self, path: Path, content: bytes) -> str:
        """The content of a file as text.

        Args:
            path: path of the file, for messages.
            content: content of the file.

        Raises:
            DataFileError: content that is not UTF-8, or that begins with a byte order mark.
        """
        try:
            text = content.decode("utf-8")
        except UnicodeDecodeError as fault:
            what = f"is not text in UTF-8: {fault.reason} at byte {fault.start}"
            raise self.error(path, what) from None
        if text.startswith(_BYTE_ORDER):
            raise self.error(path, "begins with a byte order mark; it must be saved as UTF-8 without one")
        return text

    def _parsed(self, path: Path, text: str, parse: Callable[[str], Any]) -> Any:
        try:
            return parse(text)
        except DataTextError as fault:
            raise self.error(path, f"cannot be read as {fault.language}: {fault.what}") from None
