"""The errors that prp_gym raises: one root, facts as attributes, and a message that helps.

Each message says what was wrong, which value it had, in which unit, and what is allowed. Errors about a value
also derive from `ValueError` and errors about a state from `RuntimeError`, so that code without knowledge of
this package can catch them. All of them can be pickled, and can be made from a message alone, as libraries do
that raise an error of another process again.
"""

import inspect
import reprlib
from collections.abc import Iterable, Sequence, Set
from typing import Any

import numpy as np

from prp_gym.nearest import nearest_name

_LONGEST_VALUE = 160  # characters of a value in a message
_LONGEST_PATH = 400  # characters of a path in a message
_MOST_BITS = 512  # of an integer that is written out
_MOST_BYTES = 512  # of an array that is written out
_MOST_ENTRIES = 100  # of a dictionary or set that is written out


class _ShortRepr(reprlib.Repr):
    """Texts of values of any kind and size, in bounded time."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.maxlevel = 4
        self.maxstring = self.maxother = width
        self.maxlist = self.maxtuple = self.maxdict = self.maxset = self.maxfrozenset = 12

    def repr1(self, x: Any, level: int) -> str:
        """The text of one value; the kinds whose own text may be endless are cut or described first."""
        if isinstance(x, int) and x.bit_length() > _MOST_BITS:
            return f"<{type(x).__name__} of {x.bit_length()} bits>"
        if isinstance(x, (str, bytes, bytearray)) and len(x) > self.maxstring:
            half = self.maxstring // 2
            return f"{x[:half]!r}...{x[-half:]!r}"
        if isinstance(x, (np.ndarray, np.generic)) and (x.dtype.hasobject or x.nbytes > _MOST_BYTES):
            return f"<array of shape {x.shape} and type {x.dtype.name}>"
        if isinstance(x, (dict, Set)) and len(x) > _MOST_ENTRIES:
            return f"<{type(x).__name__} of {len(x)} entries>"
        return super().repr1(x, level)


def shortened(value: object, width: int = 80) -> str:
    """The text of a value for a message: its `repr`, from which the middle is left out if it is too long.

    Args:
        value: any object, of any size, also one without a text of its own.
        width: largest number of characters.
    """
    try:
        text = _ShortRepr(width).repr(value)
    except Exception:  # whatever the value's own methods raise
        text = f"<{type(value).__name__} without a text>"
    half = (width - 3) // 2
    return text if len(text) <= width else f"{text[:half]}...{text[-half:]}"


class ErrorType(type):
    """Class of the error classes, which lets an error be made from its message instead of its facts.

    A constructor that requires several facts would refuse `type(error)(str(error))`, with which Gymnasium and
    TorchRL raise an error again. Given one argument, such a class makes an error of that message; its facts
    are known only if the argument is an error of the same class.
    """

    def __call__(cls, *arguments: Any, **facts: Any) -> Any:
        """Make an error from its facts, or from a message or another error of this class."""
        if len(arguments) == 1 and not facts and _required_facts(cls) > 1:
            (origin,) = arguments
            return _rebuild(cls, (str(origin),), vars(origin) if isinstance(origin, cls) else {})
        return super().__call__(*arguments, **facts)


def _required_facts(kind: Any) -> int:
    """Number of arguments that the constructor of a class requires."""
    parameters = list(inspect.signature(kind.__init__).parameters.values())[1:]
    named = inspect.Parameter.POSITIONAL_OR_KEYWORD
    return sum(item.kind is named and item.default is inspect.Parameter.empty for item in parameters)


def _rebuild(kind: type[Any], arguments: tuple[Any, ...], facts: dict[str, Any]) -> Any:
    """Rebuild an error from its message and facts, without running its constructor."""
    error = kind.__new__(kind, *arguments)
    vars(error).update(facts)
    return error


class PRPError(Exception, metaclass=ErrorType):
    """Root of all errors that prp_gym raises."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (type(self), self.args, vars(self))


class UnknownNameError(PRPError, ValueError):
    """A name (environment id, controller, scenario, option, field) that does not exist."""

    def __init__(self, kind: str, name: object, valid: Iterable[str]) -> None:
        self.kind = kind
        self.name = name
        self.valid = tuple(sorted(valid))
        self.nearest = nearest_name(name, self.valid)
        hint = f" Did you mean {self.nearest!r}?" if self.nearest else ""
        listing = ", ".join(self.valid) if self.valid else "none"
        super().__init__(f"{self.problem()}.{hint} Valid: {listing}.")

    def problem(self) -> str:
        """First sentence of the message, without its full stop."""
        return f"unknown {self.kind} {shortened(self.name)}"


class UnknownKeywordError(UnknownNameError, TypeError):
    """A keyword that a call does not have, in the words in which Python refuses one.

    Libraries read those words to find out which keywords an environment takes.
    """

    def problem(self) -> str:
        """First sentence of the message, in Python's words."""
        return f"{self.kind} got an unexpected keyword argument {shortened(self.name)}"


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
        super().__init__(f"{what} has shape {shortened(self.shape)}; expected {expected}.")


class NonFiniteError(PRPError, ValueError):
    """NaN or infinity where a finite number is required; it never reaches the physics."""

    def __init__(self, what: str, value: object) -> None:
        self.what = what
        self.value = value
        super().__init__(f"{what} is {shortened(value)}; every component must be finite.")


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


class ErrorObservationError(PRPError, ValueError):
    """A controller on an environment that observes errors of order 1 in place of fields with units."""

    def __init__(self, environment_id: str, control_frequency: float) -> None:
        self.environment_id = environment_id
        self.control_frequency = control_frequency
        super().__init__(
            "observation of the environment is 'errors', as the learning presets have it; a controller reads"
            f" 'fields', quantities in their units. Make the task itself, gymnasium.make({environment_id!r},"
            f" control_frequency={control_frequency:g}): episodes, score and metrics are the same."
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

    def __init__(self, path: object, reason: str, remedy: str = "To start over, give --fresh") -> None:
        self.path = str(path)
        self.reason = reason
        self.remedy = remedy
        super().__init__(f"run folder {self.path!r}: {reason}. {remedy}.")


class FolderInUseError(PRPError, RuntimeError):
    """A folder into which another process is writing."""

    def __init__(self, path: object, holder: object) -> None:
        self.path = str(path)
        self.holder = str(holder)
        super().__init__(
            f"folder {self.path!r} is in use by {self.holder}. Wait until that has ended or end it, or choose"
            " another folder."
        )


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
        super().__init__(f"{self.label} {shortened(self.path, _LONGEST_PATH)}: {what}.{advice}")


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
    """A package that a call requires and that is not installed; `prp_gym.extras` knows its extra.

    The extra is empty if the package belongs to none.
    """

    def __init__(self, package: str, extra: str) -> None:
        self.package = package
        self.extra = extra
        wanted = f"'prp-gym[{extra}]'" if extra else package
        super().__init__(f"{package} is not installed; install it with: pip install {wanted}")


class UntraceableError(PRPError, ValueError, TypeError):
    """A formula that cannot be traced into an expression graph: it uses more than arithmetic on arrays."""


class DataDependentBranchError(UntraceableError):
    """A formula that branches on numbers that are known only when it runs."""


class CompilerError(PRPError, RuntimeError):
    """Generated code that cannot be compiled on this machine: the compiler is missing, or does not work."""


class GeneratedCodeError(PRPError, RuntimeError):
    """Generated code that a working compiler rejects.

    NumPy does not stand in for it: it is a defect of the package that generates the code. `function` is empty
    where the compiler complains of what is outside of functions.
    """

    def __init__(self, function: str, compiler: str, messages: str) -> None:
        self.function = function
        self.compiler = compiler
        self.messages = messages
        whose = f" of the function {function!r}" if function else ""
        super().__init__(
            f"{compiler} rejects the C code{whose} that prp_gym has generated. This is a defect of prp_gym;"
            f" please report it with these messages:\n{messages}"
        )


class PortError(PRPError, RuntimeError):
    """A network port on which a page cannot be served."""

    def __init__(self, host: str, port: int, reason: str) -> None:
        self.host = host
        self.port = port
        self.reason = reason
        super().__init__(
            f"port {port} of {shortened(host)} cannot be used: {reason}. Choose another one with --port, or 0"
            " for any that is free."
        )
