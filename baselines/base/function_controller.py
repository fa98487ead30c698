"""`controller`: a plain function of named observation fields becomes a controller."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, make_dataclass
from dataclasses import field as dataclass_field
from functools import partial
from typing import Any, ClassVar, Self, cast, overload

import numpy as np

from prp_gym.baselines.base.policy import Observed, StaticBaseline
from prp_gym.baselines.base.settings import LARGEST_SETTING, Settings, Vector
from prp_gym.baselines.base.spec import ControllerSpec
from prp_gym.checks import as_array, as_numbers, check_finite, text
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.robot.arrays import Array
from prp_gym.symbolic.array import is_symbolic
from prp_gym.tasks.fields import ObservationLayout

Function = Callable[..., Array]
Default = float | tuple[float, ...]

LARGEST_TORQUE = 1e150
"""Largest magnitude of a torque that a function may return; it is limited to that of the actuator."""

MODEL = "model"
"""Name of the parameter that is the nominal robot and not an observation field."""

_POSITIONAL = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)


class FunctionSettings(Settings):
    """Settings of a controller that is a function: its keyword-only parameters, finite numbers of any sign.

    One whose default is a vector takes as many numbers, or one for all components; one whose default is a
    number takes one number, or one for every joint.
    """

    lengths: ClassVar[Mapping[str, int | None]] = {}

    def sized(self, sizes: Mapping[str, int]) -> Self:
        """The same settings, after a check of the lengths; see `Settings.sized`."""
        for name in self.vectors:
            shape, length = getattr(self, name).shape, self.lengths[name] or sizes["joint"]
            if shape not in ((), (1,), (length,)):
                raise ShapeError(f"setting {name!r}", shape, f"one number or ({length},)")
        return self

    def _make_vector(self, name: str, declared: Vector) -> None:
        vector = _numbers(name, getattr(self, name))
        vector.flags.writeable = False
        object.__setattr__(self, name, vector)


class FunctionPolicy(StaticBaseline[FunctionSettings]):
    """A function of observation fields as a policy; subclasses hold the function.

    Attributes:
        function: returns joint torques (..., joints) [N m, N, N m].
        arguments: names of its positional parameters, in order.
    """

    function: ClassVar[Function]
    arguments: ClassVar[tuple[str, ...]]
    settings_class = FunctionSettings

    @classmethod
    def missing_fields(cls, layout: ObservationLayout) -> list[str]:
        """Fields that the function reads and a layout does not have; it needs no reference."""
        return [name for name in cls.measured_fields if name not in layout.names]

    def torque(self, observed: Observed) -> Array:
        """What the function returns.

        Raises:
            ShapeError: not one torque for every joint.
            InvalidValueError: no numbers.
            NonFiniteError: NaN or infinity.
        """
        values = [self.model if name == MODEL else observed[name] for name in self.arguments]
        settings = {name: getattr(self.settings, name) for name in self.settings.vectors}
        what = f"torques returned by controller function {self.function.__name__!r}"
        returned = type(self).function(*values, **settings)
        torque = as_array(what, returned)
        check_finite(what, torque, largest=LARGEST_TORQUE)
        expected = observed["joint_position"].shape
        if torque.shape != expected:
            raise ShapeError(what, torque.shape, f"{expected}, one torque for every joint")
        if is_symbolic(torque):  # compiled code refuses what is not a number
            return np.where(np.abs(torque) <= LARGEST_TORQUE, torque, np.nan)
        return torque


@dataclass(frozen=True)
class FunctionControllerSpec(ControllerSpec):
    """The declaration of a controller that is a function; calling it calls the function.

    Attributes:
        function: user's function of observation fields, as `controller` describes it.
    """

    function: Function = dataclass_field(kw_only=True)

    def __post_init__(self) -> None:
        for name in ("__module__", "__name__", "__qualname__", "__doc__"):
            object.__setattr__(self, name, getattr(self.function, name))

    def __call__(self, *args: Any, **kwargs: Any) -> Array:
        """The torques that the function returns."""
        return self.function(*args, **kwargs)

    def __reduce__(self) -> str:
        return self.function.__qualname__  # pickled by name, as functions are


@overload
def controller(function: Function) -> FunctionControllerSpec: ...


@overload
def controller(
    *, name: str | None = None, summary: str | None = None
) -> Callable[[Function], FunctionControllerSpec]: ...


def controller(
    function: Function | None = None, *, name: str | None = None, summary: str | None = None
) -> FunctionControllerSpec | Callable[[Function], FunctionControllerSpec]:
    """Make a controller from a function, as a decorator with or without arguments.

    The positional parameters of the function are names of observation fields, each (..., size) in the units
    of its declaration; one called `model` is the nominal robot, a `PRPArm` or `Link`. Its keyword-only
    parameters are the controller's settings, numbers or vectors, with the defaults that hold unless gains or
    overrides replace them. It returns joint torques (..., joints) [N m, N, N m], and works on one observation
    and on several with leading dimensions.

    Args:
        function: function that computes the torques.
        name: name of the controller; the function's name by default.
        summary: one line for lists; the first line of the function's docstring by default.

    Returns:
        a declaration for `make_baseline` and `register_controller`, which can also be called as the function.

    Raises:
        InvalidValueError: no function; a positional parameter with a default; a setting without one, or with
            one that is not numbers; `*args` or `**kwargs`.
    """
    if function is None:
        return partial(_declare, name=name, summary=summary)
    return _declare(function, name, summary)


def _declare(function: Function, name: str | None, summary: str | None) -> FunctionControllerSpec:
    if not inspect.isfunction(function):
        raise InvalidValueError("controller", function, "a function of observation fields")
    for what, given in (("name of controller", name), ("summary of controller", summary)):
        if given is not None:
            text(what, given)
    described = (inspect.getdoc(function) or "").partition("\n")[0]
    return FunctionControllerSpec(
        name=name or function.__name__,
        summary=summary or described or f"the function {function.__name__}",
        policy=_policy_class(function),
        function=function,
    )


def _policy_class(function: Function) -> type[FunctionPolicy]:
    """The class of a function's policies; it is found, and pickled, as an attribute of the declaration."""
    arguments, defaults = _parameters(function)
    origin = {"__module__": function.__module__, "__doc__": function.__doc__}
    qualified = f"{function.__qualname__}.policy"
    settings = make_dataclass(
        "FunctionSettings",
        [(name, Any, dataclass_field(default=value)) for name, value in defaults.items()],
        bases=(FunctionSettings,),
        frozen=True,
        eq=False,
        kw_only=True,
        namespace={
            **origin,
            "__qualname__": f"{qualified}.settings_class",
            "vectors": {name: Vector("setting", "") for name in defaults},
            "lengths": {n: len(value) if isinstance(value, tuple) else None for n, value in defaults.items()},
        },
    )
    attributes = {
        **origin,
        "__qualname__": qualified,
        "function": staticmethod(function),
        "arguments": arguments,
        "measured_fields": tuple(name for name in arguments if name != MODEL),
        "settings_class": settings,
    }
    return cast(type[FunctionPolicy], type(f"{function.__name__}_policy", (FunctionPolicy,), attributes))


def _parameters(function: Function) -> tuple[tuple[str, ...], dict[str, Default]]:
    """The names of a function's positional parameters, and the defaults of its settings."""
    arguments: list[str] = []
    defaults: dict[str, Default] = {}
    for name, entry in inspect.signature(function).parameters.items():
        what = f"parameter {name!r} of controller function {function.__name__!r}"
        if entry.kind in _POSITIONAL:
            if entry.default is not entry.empty:
                raise InvalidValueError(what, entry.default, "no default: it is an observation field")
            arguments.append(name)
        elif entry.kind is not entry.KEYWORD_ONLY:
            raise InvalidValueError(what, str(entry), "named parameters")
        elif name == MODEL or entry.default is entry.empty:
            allowed = f"a setting with a default, and not {MODEL!r}, which is a positional parameter"
            raise InvalidValueError(what, str(entry), allowed)
        else:
            numbers = _numbers(what, entry.default)
            defaults[name] = tuple(numbers.tolist()) if numbers.ndim else float(numbers)
    return tuple(arguments), defaults


def _numbers(what: str, given: Any) -> Array:
    """A number or a vector.

    Raises:
        InvalidValueError: anything else, or a number that is not finite.
    """
    numbers = as_numbers(what, given)
    if numbers.ndim > 1 or not (np.abs(numbers) <= LARGEST_SETTING).all():
        allowed = f"a finite number or several, magnitudes up to {LARGEST_SETTING:g}"
        raise InvalidValueError(what, given, allowed)
    return numbers
