"""`ControllerChoice`: a controller and its gains as plain text, as jobs and results hold it."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from prp_gym.errors import DataTextError, GainsFileError, InvalidValueError
from prp_gym.files.file_reader import SETTINGS_SIZE, FileReader
from prp_gym.files.toml_text import parse_toml

TUNED = "tuned"
_TOML = ".toml"


@dataclass(frozen=True)
class GainsChoice:
    """Gains of a controller: a named set or the content of a user's file, with overridden settings.

    Attributes:
        name: name of the gain set, or of the file without its folder.
        toml: content of the file; empty for a gain set.
        settings: names and values of overridden settings, the values as TOML.
    """

    name: str = TUNED
    toml: str = ""
    settings: tuple[tuple[str, str], ...] = ()

    @classmethod
    def read(cls, gains: str, settings: Iterable[str] = ()) -> Self:
        """The gains that the options of the command line name.

        Args:
            gains: name of a gain set, or path of a TOML file.
            settings: each `name=value` with a value in TOML, such as `stiffness=200`.

        Raises:
            GainsFileError: a file that cannot be read or is not TOML.
            InvalidValueError: a setting of another form.
        """
        single = tuple(_split(text) for text in settings)
        if not gains.endswith(_TOML):
            return cls(gains, "", single)
        path = Path(gains)
        reader = FileReader(SETTINGS_SIZE, GainsFileError)
        content = reader.read_text(path)
        reader.parse_toml(path, content)
        return cls(path.name, content, single)

    @property
    def values(self) -> str | Mapping[str, Any]:
        """The name of the gain set, or what the file holds."""
        return parse_toml(self.toml) if self.toml else self.name

    @property
    def overrides(self) -> dict[str, Any]:
        """The single settings by name."""
        return {name: _value(text) for name, text in self.settings}


@dataclass(frozen=True)
class ControllerChoice:
    """A controller with its gains.

    Attributes:
        name: registered name of the controller, or label of a user's code.
        sha256: SHA-256 of a user's code; empty for a registered controller.
        gains: gains of the controller.
    """

    name: str
    sha256: str = ""
    gains: GainsChoice = field(default_factory=GainsChoice)

    @property
    def file_name(self) -> str:
        """The name as a part of a file's name."""
        plain = re.sub(r"[^\w.-]+", "-", self.name)
        return f"{plain}_{self.sha256[:16]}" if self.sha256 else plain

    @property
    def facts(self) -> dict[str, Any]:
        """What a record says of a user's code: name and digest; nothing of a registered controller."""
        return {"code": {"name": self.name, "sha256": self.sha256}} if self.sha256 else {}


def _split(text: str) -> tuple[str, str]:
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name.isidentifier():
        raise InvalidValueError("--set", text, "a setting and its value in TOML, such as stiffness=200")
    _value(value)
    return name, value


def _value(text: str) -> Any:
    allowed = "a value in TOML, such as 200, [1.0, 2.0] or 'text'"
    try:
        table = parse_toml(f"value = {text}")
    except DataTextError as error:
        raise InvalidValueError("value of --set", text, f"{allowed} ({error.what})") from error
    if set(table) != {"value"}:
        raise InvalidValueError("value of --set", text, f"{allowed}, alone")
    return table["value"]
