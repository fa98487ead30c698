"""The comment at the top of a generated header: what its user has to know."""

from collections.abc import Iterator, Mapping
from importlib.metadata import version
from typing import Any

import numpy as np

from prp_gym.artifacts import to_plain
from prp_gym.baselines import Baseline
from prp_gym.evaluation.policy_state import LARGEST
from prp_gym.exporting.comment_text import comment_text
from prp_gym.exporting.controller_functions import ControllerFunctions
from prp_gym.exporting.operation_counts import count_operations
from prp_gym.files.checksum import checksum
from prp_gym.robot.parameters import TORQUE_UNITS
from prp_gym.tasks.fields import LARGEST_OBSERVATION, ObservationLayout

_PLAIN = (str, int, float, list, dict, type(None))


def header_comment(
    prefix: str, controller: Baseline[Any], functions: ControllerFunctions, facts: Mapping[str, str]
) -> str:
    """The comment, in ASCII.

    Args:
        prefix: what all names of the header begin with.
        controller: controller that is exported.
        functions: its functions.
        facts: further facts by name.
    """
    sections = {
        f"{prefix}.h: a controller of prp-gym in C99": _origin(controller, facts),
        "SETTINGS, which are constants of the code": _settings(controller),
        f"OBSERVATION: const double observation[{controller.interface.layout.size}]": _observation(
            controller.interface.layout
        ),
        f"OUTPUT: double torque[{len(controller.interface.torque_limit)}]": _output(controller),
        f"STATE: double state[{functions.state_size}]": _state(prefix, functions),
        "REFUSALS": _refusals(),
        "TIME": _time(functions),
    }
    lines = ["/*"]
    for title, content in sections.items():
        lines += [f" * {comment_text(title)}", *(f" *   {comment_text(line)}" for line in content), " *"]
    return "\n".join([*map(str.rstrip, lines[:-1]), " */\n"])


def settings_digest(controller: Baseline[Any]) -> str:
    """SHA-256 of all that a controller is made from: its settings by name, and what it controls."""
    interface = controller.interface
    settings = to_plain({name: _declared(value) for name, value in vars(controller.settings).items()})
    made = {
        "controller": controller.origin.controller,
        "environment": interface.environment_id,
        "period": interface.period,
        "torque_limit": interface.torque_limit,
        "model": controller.model.parameter_vector(),
        "settings": settings,
    }
    return checksum(to_plain(made))


def _declared(value: Any) -> Any:
    """A setting in types that have a text; another object is named by its class."""
    plain = to_plain(value)
    return plain if isinstance(plain, _PLAIN) else type(value).__qualname__


def _origin(controller: Baseline[Any], facts: Mapping[str, str]) -> Iterator[str]:
    period = controller.interface.period
    known = {
        "written by": f"prp-gym {version('prp-gym')}, command export-c; not to be edited",
        "controller": str(controller.origin),
        **facts,
        "environment": controller.interface.environment_id,
        "control period": f"{period!r} s ({round(1.0 / period, 6):g} Hz)",
        "SHA-256": f"{settings_digest(controller)} of the settings",
    }
    width = max(map(len, known))
    return (f"{name:<{width}}  {value}" for name, value in known.items())


def _settings(controller: Baseline[Any]) -> Iterator[str]:
    settings = controller.settings
    for name, unit in settings.units().items():
        numbers = ", ".join(map(repr, np.atleast_1d(getattr(settings, name)).tolist()))
        yield f"{name} [{unit}]: {numbers}" if unit else f"{name}: {numbers}"
    for name in settings.choices:
        yield f"{name}: {getattr(settings, name)}"
    yield f"robot model: {'nominal' if settings.model is None else 'given by the setting `model`'}"


def _observation(layout: ObservationLayout) -> Iterator[str]:
    yield f"{'index':>5}  {'component':<32}  {'unit':<7}  {'lowest':>10}  {'highest':>10}"
    for field in layout.fields:
        part = layout.slices[field.name]
        yield f"{field.name}, in {field.frame} coordinates: {field.description}"
        for component, index in enumerate(range(part.start, part.stop)):
            low, high = field.low[component], field.high[component]
            name, unit = f"{field.name}[{component}]", comment_text(field.units[component])
            yield f"  {index:>3}  {name:<32}  {unit:<7}  {low:>10g}  {high:>10g}"


def _output(controller: Baseline[Any]) -> Iterator[str]:
    yield "Joint torques to be applied during the control period that begins with the observation, limited:"
    for index, limit in enumerate(controller.interface.torque_limit.tolist()):
        yield f"  {index:>3}  joint {index + 1}  {TORQUE_UNITS[index]}  at most {limit!r} in magnitude"


def _state(prefix: str, functions: ControllerFunctions) -> Iterator[str]:
    if functions.state_size:
        yield "What the controller keeps from one period to the next: an array of the caller for each robot."
        yield f"{prefix}_begin sets it from the first observation of an episode,"
        yield "and must be called before the first step. No other code may change it."
    else:
        yield "The controller keeps nothing: `state` is not used and may be a null pointer."
        yield f"{prefix}_begin only checks the observation."


def _refusals() -> Iterator[str]:
    yield "Both functions return 0, or 1 where they refuse: if the observation holds NaN, infinity or a"
    yield f"number beyond {LARGEST_OBSERVATION:g}, or if the result would hold NaN or one beyond {LARGEST:g}."
    yield "Then every torque is zero and the state is left as it is. What the robot does without torque is"
    yield "the caller's responsibility. Code that assumes finite numbers (-ffast-math) would not refuse, and"
    yield "is therefore not compiled."


def _time(functions: ControllerFunctions) -> Iterator[str]:
    yield "Straight-line code without loops of unknown length, recursion or allocation: a call executes at"
    yield "most these operations, besides one comparison for each number that it reads or writes."
    yield ""
    begin, step = count_operations(functions.begin), count_operations(functions.step)
    yield f"{'':<36}  {'step':>6}  {'begin':>6}"
    for kind in step:
        if step[kind] or begin[kind]:
            yield f"{kind:<36}  {step[kind]:>6}  {begin[kind]:>6}"
    yield ""
    yield "Measure the time on your own machine, with its counter of cycles around each of many calls; the"
    yield "largest number is the worst case."
