"""The page on what actions mean."""

from collections.abc import Iterable
from itertools import accumulate

import numpy as np

from docs.tables import NOTE, numbers, table
from prp_gym.action_modes import (
    ACTION_MODES,
    ANY_CONTROLLER,
    RESIDUAL_SHARE,
    SMOOTHING_TIME,
    list_action_modes,
)
from prp_gym.envs.action_mode import INNER_FREQUENCY, TORQUE, ActionField, torque_field
from prp_gym.robot import NOMINAL
from prp_gym.tasks.fields import ObservationLayout

_RATE = f"{INNER_FREQUENCY:g}"
_LIMIT = NOMINAL.torque_limit
_INTRO = f"""What an action means is the keyword `action_mode`, of `gymnasium.make`, `gymnasium.make_vec` and
`prp_gym.make_sb3_vec_env` alike. An action is always a `Box(-1, 1, (size,), float32)`.

- In mode `{TORQUE}`, the default, it is the joint torques normalised by the actuator limits, held over a
  control period.
- In every other mode a controller runs inside the environment at {_RATE} Hz, with its `tuned` gains, on what
  a policy would observe. The action commands it, at the `control_frequency`, which must divide {_RATE}.
- References and gains follow the action with a delay of first order, {SMOOTHING_TIME:g} s: a stiff controller
  would turn every jump into an impact. The torques of a residual are added at once.
- Zero action leaves the controller as it is: the episode is, bit for bit, its own at {_RATE} Hz.
- Sensors, actuators, reward and costs work at {_RATE} Hz, as they do for a controller on its own. A step's
  reward and its terms are means over the controller's periods, its costs sums; contact force and time are
  those at the end.
- `prp_gym.evaluate` records at {_RATE} Hz, so that an agent's metrics compare with a controller's.
- An environment has the modes whose controllers read what it observes, and refuses the others with a
  `MissingFieldError`. `make_baseline` refuses environments in modes other than `{TORQUE}`.
- A mode may drive the command inputs that its controller declares, see [baselines](baselines.md).

`env.unwrapped.action_fields` holds the parts of an action, with units and bounds.
"""
_RESIDUAL_TEXT = f"""A residual is at most {RESIDUAL_SHARE:g} of the actuator limits, or of the robot's own
where the scenario or the keyword `torque_limit` allows more. The sum is clipped to the limits.
"""
_SIZES = (
    "Numbers are those of the arm. PRP-Adaptive-v0, a single link, has the first component of joint offsets"
    " and torques, with its own limit.\n"
)


def action_modes_page(layouts: Iterable[tuple[str, ObservationLayout]]) -> str:
    """Every mode with its controller, its action, and the environments that have it.

    Args:
        layouts: what each environment observes, with its id.
    """
    parts = [NOTE, "# Action modes\n", _INTRO, "## Modes\n"]
    has = {environment_id: modes_of(layout) for environment_id, layout in layouts}
    rows = [_mode(*entry, has) for entry in _entries()]
    parts.append(table(("mode", "controller", "action size", "what an action does", "environments"), rows))
    parts += [_SIZES, "## Actions\n"]
    for name, _, _, fields in _entries():
        parts += [f"### {name}\n", _fields(fields)]
    return "\n".join([*parts, _RESIDUAL_TEXT])


def modes_of(layout: ObservationLayout) -> list[str]:
    """The modes of an environment, those of a family as one."""
    names = [TORQUE, *(spec.label for spec in ACTION_MODES.values() if spec.is_family)]
    names += [name for name in list_action_modes(layout) if name in ACTION_MODES]
    order = [TORQUE, *(spec.label for spec in ACTION_MODES.values())]
    return sorted(names, key=order.index)


def _entries() -> list[tuple[str, str, str, tuple[ActionField, ...]]]:
    """Name, controller, summary and fields of every mode."""
    torque: tuple[ActionField, ...] = (torque_field(np.array(_LIMIT)),)
    entries = [(TORQUE, "", "is the joint torques", torque)]
    for spec in ACTION_MODES.values():
        inside = spec.entry.controller
        shown = "any that runs there" if inside == ANY_CONTROLLER else f"`{inside}`" if inside else ""
        entries.append((spec.label, shown, spec.summary, spec.entry.fields(_LIMIT, _LIMIT)))
    return entries


def _mode(
    name: str, controller: str, summary: str, fields: tuple[ActionField, ...], has: dict[str, list[str]]
) -> tuple[str, ...]:
    conditions = [environment_id for environment_id, modes in has.items() if name in modes]
    where = "all" if len(conditions) == len(has) else ", ".join(conditions)
    return f"`{name}`", controller, str(sum(field.size for field in fields)), summary, where


def _fields(fields: tuple[ActionField, ...]) -> str:
    ends = list(accumulate(field.size for field in fields))
    rows = [
        (
            f"{end - field.size} to {end - 1}",
            f"`{field.name}`",
            ", ".join(field.units),
            field.frame,
            _bounds(field),
            field.description,
        )
        for field, end in zip(fields, ends, strict=True)
    ]
    return table(("index", "field", "unit", "frame", "means, from -1 to 1", "meaning"), rows)


def _bounds(field: ActionField) -> str:
    if field.factor:
        return f"{numbers(field.low[:1])} to {numbers(field.bound[:1])}, in equal ratios; 1 at 0"
    return f"±({numbers(field.bound)})"
