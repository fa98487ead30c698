"""What a setting of a recipe may be: its type and its bounds, by kind of setting."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from prp_gym.errors import InvalidValueError, UnknownNameError

_LINEAR = "lin_"


class SettingKind(Protocol):
    """Type and bounds of a setting."""

    @property
    def allowed(self) -> str:
        """What is allowed, for messages."""

    def read(self, name: str, value: object) -> Any:
        """The setting that a recipe's value stands for, as a recipe stores it.

        Args:
            name: name of the setting, for messages.
            value: plain value of the recipe.

        Raises:
            InvalidValueError: a value of another type, or out of bounds.
            UnknownNameError: a name that does not exist.
        """


@dataclass(frozen=True)
class NumberSetting:
    """A finite number.

    Attributes:
        low: smallest number.
        high: largest number.
        above: whether the number must be above `low`.
    """

    low: float
    high: float
    above: bool = False

    @property
    def allowed(self) -> str:
        """See `SettingKind.allowed`."""
        first = f"above {self.low:g} and at most" if self.above else f"from {self.low:g} to"
        return f"a number {first} {self.high:g}"

    def read(self, name: str, value: object) -> float:
        """See `SettingKind.read`."""
        if type(value) not in (int, float) or not self.low <= value <= self.high:  # type: ignore[operator]
            raise InvalidValueError(name, value, self.allowed)
        if self.above and value == self.low:
            raise InvalidValueError(name, value, self.allowed)
        return value  # type: ignore[return-value]


@dataclass(frozen=True)
class CountSetting:
    """A whole number; 1e6 stands for 1000000.

    Attributes:
        low: smallest number.
        high: largest number.
    """

    low: int
    high: int

    @property
    def allowed(self) -> str:
        """See `SettingKind.allowed`."""
        return f"a whole number from {self.low} to {self.high}"

    def read(self, name: str, value: object) -> int:
        """See `SettingKind.read`."""
        whole = type(value) is int or (type(value) is float and value.is_integer())
        if not whole or not self.low <= value <= self.high:  # type: ignore[operator]
            raise InvalidValueError(name, value, self.allowed)
        return int(value)  # type: ignore[call-overload, no-any-return]


@dataclass(frozen=True)
class FlagSetting:
    """True or false."""

    @property
    def allowed(self) -> str:
        """See `SettingKind.allowed`."""
        return "true or false"

    def read(self, name: str, value: object) -> bool:
        """See `SettingKind.read`."""
        if not isinstance(value, bool):
            raise InvalidValueError(name, value, self.allowed)
        return value


@dataclass(frozen=True)
class ChoiceSetting:
    """One of several names.

    Attributes:
        names: names to choose from.
    """

    names: tuple[str, ...]

    @property
    def allowed(self) -> str:
        """See `SettingKind.allowed`."""
        return f"one of {', '.join(self.names)}"

    def read(self, name: str, value: object) -> str:
        """See `SettingKind.read`."""
        if not isinstance(value, str) or value not in self.names:
            raise UnknownNameError(name, value, self.names)
        return value


@dataclass(frozen=True)
class OptionalSetting:
    """A setting, or a word or null in its stead.

    Attributes:
        kind: kind of the setting.
        other: word that is allowed, too; None for null.
    """

    kind: SettingKind
    other: str | None = None

    @property
    def allowed(self) -> str:
        """See `SettingKind.allowed`."""
        return f"{self.kind.allowed}, or {'null' if self.other is None else self.other}"

    def read(self, name: str, value: object) -> Any:
        """See `SettingKind.read`."""
        if (value is None or isinstance(value, str)) and value == self.other:
            return value
        try:
            return self.kind.read(name, value)
        except InvalidValueError:
            raise InvalidValueError(name, value, self.allowed) from None


@dataclass(frozen=True)
class PrefixedSetting:
    """A number, or a text of a prefix and a number, such as `lin_5e-4`.

    Attributes:
        number: numbers that are allowed.
        prefix: prefix of a text.
        meaning: what a text stands for, in messages.
    """

    number: NumberSetting
    prefix: str
    meaning: str

    @property
    def allowed(self) -> str:
        """See `SettingKind.allowed`."""
        return f"{self.number.allowed}, or {self.meaning}: {self.prefix} and a number"

    def read(self, name: str, value: object) -> float | str:
        """See `SettingKind.read`."""
        prefixed = isinstance(value, str) and value.startswith(self.prefix)
        try:
            self.number.read(name, float(value.removeprefix(self.prefix)) if prefixed else value)  # type: ignore[attr-defined]
        except ValueError:
            raise InvalidValueError(name, value, self.allowed) from None
        return value  # type: ignore[return-value]


@dataclass(frozen=True)
class LayersSetting:
    """Sizes of a network's hidden layers: a list for all networks, or a list for each of several networks.

    Attributes:
        networks: names of the networks that may have their own list.
        most: largest number of layers.
        widest: largest number of units of a layer.
    """

    networks: tuple[str, ...]
    most: int = 8
    widest: int = 4096

    @property
    def allowed(self) -> str:
        """See `SettingKind.allowed`."""
        own = " and ".join(self.networks)
        return f"a list of at most {self.most} sizes from 1 to {self.widest}, or one each for {own}"

    def read(self, name: str, value: object) -> Any:
        """See `SettingKind.read`."""
        lists = value.values() if isinstance(value, Mapping) and set(value) == set(self.networks) else [value]
        for sizes in lists:
            if not isinstance(sizes, list) or len(sizes) > self.most:
                raise InvalidValueError(name, value, self.allowed)
            for size in sizes:
                if type(size) is not int or not 1 <= size <= self.widest:
                    raise InvalidValueError(name, value, self.allowed)
        return value


def schedule(low: float, high: float) -> PrefixedSetting:
    """A constant, or the start of a schedule that falls linearly to zero.

    Args:
        low: number above which the value must be.
        high: largest value.
    """
    return PrefixedSetting(NumberSetting(low, high, above=True), _LINEAR, "a schedule that falls linearly")
