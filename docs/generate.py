"""Generate the documentation pages that are made from declarations: `make docs`.

A test fails when a committed page differs from what this module would write.
"""

import dataclasses
import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import gymnasium

from docs.action_modes_page import action_modes_page, modes_of
from docs.audit_page import audit_page
from docs.clients_page import clients_page
from docs.command_line_page import command_line_page
from docs.learning_page import learning_page
from docs.metrics_page import metrics_page
from docs.presets_section import presets_section
from docs.tables import NOTE, numbers, table
from prp_gym.baselines import CONTROLLERS, list_baselines
from prp_gym.envs import EnvConfig, PRPEnv, PRPVectorEnv
from prp_gym.envs.base.scenarios import load_scenario
from prp_gym.tasks.fields import ObservationLayout
from prp_gym.tasks.scenario import SCENARIOS
from prp_gym.tasks.spec import TASKS

_CONTACT_DRAWS = (
    "\n`contact` is the joint position at the first contact (rad, m, rad). The surface is perpendicular to"
    " the slide's direction there; an extending slide presses on it if `side` is positive, a retracting one"
    " otherwise. `start` and `waypoints` are relative to the contact: rotation of joint 1 (rad), depth below"
    " the surface (m), rotation of joint 3 (rad). The unit of `interval` is s, of stiffness N/m, of damping"
    " N·s/m, of forces N and of depths m.\n"
)
FOLDER = Path(__file__).parent


def environments_page() -> str:
    """Ids, keywords, scenarios, and a data sheet of every environment."""
    parts = [NOTE, "# Environments\n"]
    parts.append(table(("id", "task"), ((f"`{entry.id}`", entry.summary) for entry in TASKS.values())))
    parts.append("\n## Keywords of every environment\n")
    parts.append(_keywords(EnvConfig))
    parts.append("\n## Scenarios\n")
    parts.append(
        table(("scenario", "description"), ((f"`{s}`", load_scenario(s).description) for s in SCENARIOS))
    )
    parts.append("\n## Vector environments\n")
    parts.append(_vector_keywords())
    parts.append("\n## Action\n")
    parts.append(
        "The action space is `Box(-1, 1, (size,), float32)`. The keyword `action_mode` determines the meaning"
        " of an action, see [action modes](action_modes.md). By default it is the vector of joint torques"
        " (three, one for PRP-Adaptive-v0) normalised by the actuator limits `env.unwrapped.torque_limit`"
        " [N·m, N, N·m]. Values beyond ±1 are clipped, and `info` counts the clipped torques. NaN, infinity"
        " and another shape raise an error.\n"
    )
    parts += ["\n## Learning presets\n", presets_section()]
    for entry in TASKS.values():
        parts.append(_data_sheet(gymnasium.make(entry.id).unwrapped, entry.id))
    return "\n".join(parts)


def _layouts() -> list[tuple[str, ObservationLayout]]:
    """Ids of all environments with their observation layouts."""
    made = [(entry.id, gymnasium.make(entry.id)) for entry in TASKS.values()]
    return [(name, env.get_wrapper_attr("observation_layout")) for name, env in made]


def _keywords(declaration: type[Any]) -> str:
    entries = dataclasses.fields(declaration)
    rows = [
        (f"`{e.name}`", f"`{e.default!r}`", e.metadata["unit"], e.metadata["description"]) for e in entries
    ]
    return table(("keyword", "default", "unit", "meaning"), rows)


def _vector_keywords() -> str:
    """Keywords of `gymnasium.make_vec` in addition to those of a single environment."""
    text = inspect.getdoc(PRPVectorEnv) or ""
    meanings = _attributes(text, "Args")
    rows = [
        (f"`{name}`", f"`{getattr(entry.default, 'value', entry.default)!r}`", meanings[name])
        for name, entry in inspect.signature(PRPVectorEnv).parameters.items()
        if entry.kind is not entry.VAR_KEYWORD and entry.default is not entry.empty
    ]
    about = " ".join(text.split("\n\n")[1].split())
    intro = f"`gymnasium.make_vec(id, num_envs=N, ...)` makes a `PRPVectorEnv`. {about}\n"
    return f"{intro}\n" + table(("keyword", "default", "meaning"), rows)


def _data_sheet(env: Any, environment_id: str) -> str:
    if not isinstance(env, PRPEnv):
        raise TypeError(f"{environment_id} is not an environment of this suite")
    parts = [f"\n## {environment_id}\n", _sheet_text(env), ""]
    options = env.task_spec.entry.options
    if dataclasses.fields(options):
        parts += ["### Additional keywords\n", _keywords(options)]
    parts += ["### Observation\n", _observation(env)]
    parts += ["### Reward\n", _reward(env)]
    parts += ["### Info\n"]
    parts.append(
        table(("name", "unit", "meaning"), ((f"`{f.name}`", f.unit, f.description) for f in env.info_fields))
    )
    parts += ["### Start, end, reset options\n", _ranges(env)]
    if env.task.numbers.constants:
        parts.append(table(("constant", "value"), _constants("", env.task.numbers.constants)))
        parts.append("Forces are in N, target models in kg, N·s/m, N/m and kg·m², N·m·s/rad, N·m/rad.\n")
    rows = [(f"`{n}`", f"`{o.shape}`", o.unit, o.description) for n, o in env.task.reset_options.items()]
    parts.append("`reset(options=...)` accepts:\n\n" + table(("option", "shape", "unit", "meaning"), rows))
    parts.append(
        "The episode is truncated after `duration`. It is terminated only if the simulation diverges, that"
        " is, if it exceeds the declared bounds of joint position or velocity, or if MuJoCo meets a value"
        " that is not finite.\n"
    )
    controllers = ", ".join(f"`{name}`" for name in list_baselines(env.observation_layout))
    parts.append(f"Controllers that run on this task: {controllers}.\n")
    modes = ", ".join(f"`{name}`" for name in modes_of(env.observation_layout))
    parts.append(f"Action modes: {modes}.\n")
    return "\n".join(parts)


def _sheet_text(env: PRPEnv) -> str:
    """Data sheet of a task, the docstring of its composition."""
    return inspect.getdoc(env.task_spec.entry.compose) or ""


def _constants(prefix: str, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Names and values of a task's constants, nested names joined by dots."""
    rows: list[tuple[str, str]] = []
    for name, value in values.items():
        if isinstance(value, Mapping):
            rows += _constants(f"{prefix}{name}.", value)
        else:
            rows.append((f"`{prefix}{name}`", _value(value)))
    return rows


def _observation(env: PRPEnv) -> str:
    rows = []
    for field in env.observation_layout.fields:
        part = env.observation_layout.index(field.name)
        index = f"{part.start} to {part.stop - 1}"
        rows.append(
            (
                index,
                f"`{field.name}`",
                ", ".join(field.units),
                field.frame,
                f"±({numbers(field.high)})",
                field.description,
            )
        )
    text = f"`Box` of {env.observation_layout.size} float64.\n\n"
    return text + table(("index", "field", "unit", "frame", "bounds", "meaning"), rows)


def _reward(env: PRPEnv) -> str:
    text = (
        "The reward of a step is Σ w κ(‖e/s‖) with κ(z) = 1/(1 + z). The score is the mean reward"
        " over the planned steps.\n\n"
    )
    rows = [
        (f"`{t.name}`", f"{t.weight:g}", numbers(t.scale), ", ".join(t.unit)) for t in env.task.numbers.reward
    ]
    return text + table(("term", "weight w", "scale s", "unit"), rows)


def _ranges(env: PRPEnv) -> str:
    rows = []
    for draws, ranges in env.task.numbers.ranges.items():
        for name, bounds in ranges.items():
            how = "logarithm" if bounds.logarithmic else "value"
            fixed = bounds.low == bounds.high
            limits = (numbers(bounds.low), "" if fixed else numbers(bounds.high))
            rows.append((f"`{draws}`", f"`{name}`", *limits, "fixed" if fixed else how))
    text = table(("scenario kind", "quantity", "lower bound", "upper bound", "uniform in"), rows)
    return text + _CONTACT_DRAWS if "contact" in next(iter(env.task.numbers.ranges.values())) else text


def baselines_page() -> str:
    """Every controller with its equation, settings and gain sets."""
    parts = [NOTE, "# Baselines\n"]
    rows = ((f"`{name}`", spec.summary) for name, spec in CONTROLLERS.items())
    parts.append(table(("controller", "description"), rows))
    for name, spec in CONTROLLERS.items():
        parts += [f"\n## {name}\n", inspect.getdoc(spec.policy) or "", "\n### Settings\n"]
        parts.append(_controller_settings(spec.settings_class))
        inputs = ", ".join(f"`{item}`" for item in spec.command_inputs) or "none"
        parts.append(f"Command inputs that [action modes](action_modes.md) may drive: {inputs}.\n")
        parts += ["### Gain sets\n", _gain_sets(spec.data.gains)]
    return "\n".join(parts)


def _controller_settings(settings: type[Any]) -> str:
    """A table of a controller's settings, the inherited ones last."""
    meanings: dict[str, str] = {}
    for declaration in settings.__mro__:
        text = vars(declaration).get("__doc__") or ""
        if dataclasses.is_dataclass(declaration) and "Attributes:\n" in text:
            meanings |= {k: v for k, v in _attributes(text).items() if k not in meanings}
    entries = {entry.name: entry for entry in dataclasses.fields(settings)}
    rows = [
        (f"`{name}`", _default(entries[name]), text) for name, text in meanings.items() if name in entries
    ]
    return table(("setting", "default", "meaning"), rows)


def _default(entry: dataclasses.Field[Any]) -> str:
    return "" if entry.default is dataclasses.MISSING else f"`{entry.default!r}`"


def _attributes(text: str, heading: str = "Attributes") -> dict[str, str]:
    """Names and descriptions under a heading of a docstring, with the lines of each description joined."""
    described: dict[str, str] = {}
    lines = inspect.cleandoc(text).split(f"{heading}:\n")[1].split("\n\n")[0].splitlines()
    for line in lines:
        if line.startswith("     "):
            described[list(described)[-1]] += " " + line.strip()
        else:
            name, _, rest = line.strip().partition(": ")
            described[name] = rest
    return described


def _gain_sets(sets: Mapping[str, Mapping[str, Any]]) -> str:
    rows = []
    for name, values in sets.items():
        shared = {key: value for key, value in values.items() if not isinstance(value, dict)}
        rows.append((f"`{name}`", "all", _settings(shared), str(shared["source"])))
        for environment_id, own in values.items():
            if isinstance(own, dict):
                rows.append((f"`{name}`", environment_id, _settings(own), str(own["source"])))
    return table(("set", "environment", "values", "source"), rows)


def _value(value: Any) -> str:
    if isinstance(value, list):
        return numbers(value)
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_value(item)}" for name, item in value.items())
    return f"{value:g}" if isinstance(value, float) else str(value)


def _settings(values: Mapping[str, Any]) -> str:
    return "; ".join(f"{key} {_value(value)}" for key, value in values.items() if key != "source")


PAGES = {
    "environments.md": environments_page,
    "action_modes.md": lambda: action_modes_page(_layouts()),
    "baselines.md": baselines_page,
    "metrics.md": metrics_page,
    "command_line.md": command_line_page,
    "clients.md": clients_page,
    "learning.md": learning_page,
    "audit.md": audit_page,
}


def main() -> None:
    """Write every generated page."""
    for name, make in PAGES.items():
        (FOLDER / name).write_text(make(), encoding="utf-8")


if __name__ == "__main__":
    main()
