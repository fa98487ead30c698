"""The errors that prp_gym raises: one root, facts as attributes, and a message that helps.

Each message says what was wrong, which value it had, in which unit, and what is allowed. Errors about a value
also derive from `ValueError` and errors about a state from `RuntimeError`, so that code without knowledge of
this package can catch them. All of them can be pickled, as vector environments in processes require.
"""

import difflib
from collections.abc import Iterable, Sequence
from typing import Any

_LONGEST_VALUE, _LONGEST_NAME = 400, 200  # characters


def shortened(value: object, width: int = 80) -> str:
    """The representation of a value for a message, cut to a number of characters.

    Args:
        value: value of any kind.
        width: largest number of characters.
    """
    try:
        text = repr(value)
    except Exception:  # too deep, too long, or a faulty __repr__
        text = f"<{type(value).__name__}>"
    return text if len(text) <= width else f"{text[: width - 3]}..."


class PRPError(Exception):
    """Root of all errors that prp_gym raises."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (type(self), self.args, vars(self))


def _rebuild(kind: type[PRPError], arguments: tuple[Any, ...], facts: dict[str, Any]) -> PRPError:
    """Rebuild an unpickled error from its message and facts, without running its constructor."""
    error = kind.__new__(kind, *arguments)
    vars(error).update(facts)
    return error


class UnknownNameError(PRPError, ValueError):
    """A name (environment id, controller, scenario, option, field) that does not exist."""

    def __init__(self, kind: str, name: object, valid: Iterable[str]) -> None:
        self.kind = kind
        self.name = name
        self.valid = tuple(sorted(valid))
        near = difflib.get_close_matches(str(name)[:_LONGEST_NAME], self.valid, n=1)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        listing = ", ".join(self.valid) if self.valid else "none"
        super().__init__(f"unknown {kind} {shortened(name)}.{hint} Valid: {listing}.")


class InvalidValueError(PRPError, ValueError):
    """A value that is not allowed."""

    def __init__(self, what: str, value: object, allowed: str, unit: str = "") -> None:
        self.what = what
        self.value = value
        self.allowed = allowed
        self.unit = unit
        shown = f"{shortened(value, _LONGEST_VALUE)} {unit}".rstrip()
        super().__init__(f"{what} is {shown}; allowed: {allowed}.")


class ShapeError(PRPError, ValueError):
    """An array of the wrong shape."""

    def __init__(self, what: str, shape: Sequence[int], expected: str) -> None:
        self.what = what
        self.shape = tuple(shape)
        self.expected = expected
        super().__init__(f"{what} has shape {self.shape}; expected {expected}.")


class NonFiniteError(PRPError, ValueError):
    """NaN or infinity where a finite number is required; it never reaches the physics."""

    def __init__(self, what: str, value: object) -> None:
        self.what = what
        self.value = value
        super().__init__(f"{what} is {value}; every component must be finite.")


class JointLimitError(PRPError, ValueError):
    """A joint value outside the joint's range."""

    def __init__(self, what: str, joint: int, value: float, limits: tuple[float, float], unit: str) -> None:
        self.what = what
        self.joint = joint
        self.value = value
        self.limits = limits
        self.unit = unit
        super().__init__(
            f"{what}: joint {joint} is {value:.6g} {unit};"
            f" allowed: {limits[0]:.6g} to {limits[1]:.6g} {unit}."
        )


class UnreachableError(PRPError, ValueError):
    """A tip position that no joint configuration within the limits attains."""

    def __init__(self, position: Sequence[float], residual: float, broken: Sequence[str]) -> None:
        self.position = tuple(position)
        self.residual = residual
        self.broken = tuple(broken)
        point = ", ".join(f"{value:.6g}" for value in self.position)
        super().__init__(
            f"tip position ({point}) m in the world frame is out of reach: the nearest branch, clipped to"
            f" the joint limits, misses it by {residual:.6g} m; broken: {'; '.join(self.broken)}."
        )


class MissingFieldError(PRPError, ValueError):
    """A controller on an observation that lacks what the controller reads."""

    def __init__(self, controller: str, missing: Sequence[str], available: Sequence[str]) -> None:
        self.controller = controller
        self.missing = tuple(missing)
        self.available = tuple(available)
        super().__init__(
            f"controller {controller!r} reads observation fields that this environment does not give:"
            f" {', '.join(self.missing)}. Fields given: {', '.join(self.available)}."
        )


class EpisodeError(PRPError, RuntimeError):
    """A call that the current state of the episode does not permit."""


class CheckpointError(PRPError, RuntimeError):
    """A training checkpoint that cannot be read."""

    def __init__(self, path: object, reason: object) -> None:
        self.path = str(path)
        self.reason = str(reason)
        super().__init__(
            f"checkpoint {self.path!r} cannot be read: {self.reason}. Training cannot go on from it;"
            " --fresh starts over."
        )


class RunFolderError(PRPError, RuntimeError):
    """The folder of a training run in which a training can neither start nor resume."""

    def __init__(self, path: object, reason: str) -> None:
        self.path = str(path)
        self.reason = reason
        super().__init__(f"run folder {self.path!r}: {reason}. To start over, give --fresh.")


class OutputError(PRPError, RuntimeError):
    """A file or folder that cannot be written."""

    def __init__(self, path: object, reason: object) -> None:
        self.path = str(path)
        self.reason = str(reason)
        super().__init__(f"cannot write to {self.path!r}: {self.reason}")


class DataTextError(PRPError, ValueError):
    """A text in JSON, TOML or YAML that cannot be read, or that holds more than plain values."""

    def __init__(self, language: str, what: str) -> None:
        self.language = language
        self.what = what
        super().__init__(f"the text cannot be read as {language}: {what}.")


class DataFileError(PRPError, ValueError):
    """A file that is missing, damaged, too large, not a regular file, or that holds what it may not hold.

    The remedy, where there is one, says what to do.
    """

    label = "file"

    def __init__(self, path: object, what: str, remedy: str = "") -> None:
        self.path = str(path)
        self.what = what
        self.remedy = remedy
        advice = f" {remedy}." if remedy else ""
        super().__init__(f"{self.label} {shortened(self.path, _LONGEST_VALUE)}: {what}.{advice}")


class GainsFileError(DataFileError):
    """A TOML file of gains that is missing, is not TOML, or holds what a controller does not have."""

    label = "gains file"


class AgentFileError(DataFileError):
    """The file of a trained agent that is missing, damaged, altered or of another kind."""

    label = "agent file"


class PluginError(PRPError, RuntimeError):
    """A plugin that cannot be loaded."""

    def __init__(self, name: str, reason: str, file: str = "", line: int = 0) -> None:
        self.name = name
        self.reason = reason
        self.file = file
        self.line = line
        where = f"{file}, line {line}: " if file else ""
        super().__init__(f"plugin {name!r} cannot be loaded: {where}{reason}")


class UserCodeError(PRPError, RuntimeError):
    """Code that a user has given and that fails, with the line in the user's file."""

    def __init__(self, file: str, line: int, reason: str, environment_id: str = "") -> None:
        self.file = file
        self.line = line
        self.reason = reason
        self.environment_id = environment_id
        where = f" (on {environment_id})" if environment_id else ""
        super().__init__(f"{file}, line {line}: {reason}{where}")


class PolicyOutputError(PRPError, ValueError):
    """What a policy's `predict` returned, where it is not an action and a state."""

    def __init__(self, policy: str, found: str, shape: Sequence[int]) -> None:
        self.policy = policy
        self.found = found
        self.shape = tuple(shape)
        super().__init__(
            f"predict of {policy} returned {found}; it must return (action, state) with finite actions of"
            f" shape {self.shape} for one observation, or with a leading dimension for several if the policy"
            " has the attribute `batched = True`."
        )


class RenderingError(PRPError, RuntimeError):
    """A frame that cannot be drawn on this machine or in this mode."""


class MissingPackageError(PRPError, RuntimeError):
    """A package that a call requires and that is not installed."""

    def __init__(self, package: str, extra: str) -> None:
        self.package = package
        self.extra = extra
        super().__init__(f"{package} is not installed; install it with: pip install 'prp-gym[{extra}]'")
