"""The command `prp-gym export-c`."""

from contextlib import closing
from pathlib import Path
from typing import Annotated, Any

import gymnasium
import typer

from prp_gym.artifacts import write_file
from prp_gym.cli import completion
from prp_gym.cli.one_policy import name_by_argument
from prp_gym.cli.options import (
    ControlFrequency,
    Gains,
    Json,
    OneController,
    OneEnvironment,
    Plugins,
    Quiet,
    RunName,
    RunOutput,
    Settings,
    only,
)
from prp_gym.console.terminal import Terminal
from prp_gym.errors import InvalidValueError
from prp_gym.exporting.c_header import CHeader, c_header, checked_prefix
from prp_gym.exporting.controller_functions import require_traceable
from prp_gym.runs.choice import TUNED, ControllerChoice, GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.runs.selection import check_names
from prp_gym.runs.tuning_candidates import choose_controller
from prp_gym.tasks.registration import list_envs

_SUFFIX = ".h"

ControllerArgument = Annotated[
    str | None,
    typer.Argument(
        help="Controller to export, in place of --baseline.", autocompletion=completion.controllers
    ),
]
Prefix = Annotated[
    str | None,
    typer.Option(
        help="What all names of the header begin with, so that several fit into one program.",
        show_default="prp_<controller>_<task>",
    ),
]


def export_c_command(
    env: OneEnvironment,
    controller: ControllerArgument = None,
    baseline: OneController = None,
    gains: Gains = TUNED,
    settings: Settings = None,
    control_frequency: ControlFrequency = 500.0,
    prefix: Prefix = None,
    output: RunOutput = None,
    name: RunName = "",
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Write a controller as one header in C99, for microcontrollers and real-time loops.

    The header needs <math.h> alone. It computes the torques of the controller in double precision, without
    allocation, global variables or loops of unknown length; the comment at its top says what the observation
    holds. --output is the header, a file that ends in .h.

    A controller of your own can be exported too if it derives from Baseline or is a function with
    @prp_gym.controller, and consists of arithmetic on arrays alone.
    """
    (environment_id,) = check_names("environment", [only("--env", env)], list_envs())
    if output is not None and output.suffix != _SUFFIX:
        raise InvalidValueError("--output", str(output), f"a file that ends in {_SUFFIX}")
    if prefix is not None:
        checked_prefix(prefix)
    chosen = name_by_argument(controller, baseline or [])
    choice, controllers = choose_controller(chosen, GainsChoice.read(gains, settings or ()))
    header = _export(choice, controllers, environment_id, control_frequency, prefix)
    target = _write(header, output, name)
    content = {
        "header": str(target),
        "prefix": header.prefix,
        "environment": environment_id,
        "controller": choice.name,
        "observation_size": header.observation_size,
        "state_size": header.state_size,
        "torque_size": header.torque_size,
        "operations": header.operations,
    }
    Terminal.of(quiet, as_json).report(content, lines=[f"header: {target}"])


def _export(
    choice: ControllerChoice,
    controllers: Controllers,
    environment_id: str,
    control_frequency: float,
    prefix: str | None,
) -> CHeader:
    """The header of a controller, which is tried out first."""
    with closing(gymnasium.make(environment_id, control_frequency=control_frequency)) as env:
        policy: Any = controllers.try_out(choice, env)
        require_traceable(policy)
        code = {"code": f"{choice.name}, SHA-256 {choice.sha256}"} if choice.sha256 else {}
        gains = {"gains": choice.gains.name}
        with controllers.reported(choice, env):
            return c_header(policy, prefix, {**code, **gains})


def _write(header: CHeader, output: Path | None, name: str) -> Path:
    """Write the header, into a folder of its own unless a file is named."""
    folder = ResultFolder.choose(
        "export-c", None if output is None else output.parent, name, [], goes_on=False
    )
    target = folder.path / f"{header.prefix}{_SUFFIX}" if output is None else output
    with folder.in_use():
        write_file(target, header.text.encode("ascii"))
    return target
