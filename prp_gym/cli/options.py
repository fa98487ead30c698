"""The options of all commands: an option has one name, one short form, one type and one help text.

A command takes the type alias of an option, and its own default. Options of one command alone, which no other
may give another meaning, are declared beside that command.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.checks import choice
from prp_gym.cli import completion
from prp_gym.errors import CompilerError, InvalidValueError
from prp_gym.figures.figure_file import SUFFIXES
from prp_gym.plugins import load_plugins
from prp_gym.symbolic.compiler import require_compiled_code
from prp_gym.tables.formats import FORMATS, TERMINAL
from prp_gym.tasks.setup import COMPILED, ENGINES, MUJOCO

_KINDS = tuple(suffix[1:] for suffix in SUFFIXES)


def _load(modules: list[str] | None) -> list[str] | None:
    load_plugins(modules or [])
    return modules


def _check_format(value: str) -> str:
    return choice("--format", value, FORMATS)


def _check_figure_format(value: str) -> str:
    return choice("--figure-format", value, _KINDS)


def _check_engine(value: str | None) -> str | None:
    """An engine that exists, and that this machine can run.

    Raises:
        UnknownNameError: an engine that does not exist.
        CompilerError: the compiled engine on a machine with neither compiled code nor a compiler.
    """
    if value is None or choice("--engine", value, ENGINES) != COMPILED:
        return value
    try:
        require_compiled_code()
    except CompilerError as error:
        raise CompilerError(f"--engine {value}: {error} --engine {MUJOCO} needs none.") from error
    return value


def _engine(default: str | bool) -> Any:
    return typer.Option(
        "--engine",
        help=f"What simulates the robot: {', '.join(ENGINES)}. The first is the reference; the second is "
        "many times as fast, with scores that differ by less than 1e-6 where the control is stable, and "
        "needs a C compiler, or a wheel with compiled code.",
        show_default=default,
        callback=_check_engine,
        autocompletion=completion.engines,
    )


def _env(default: str | bool) -> Any:
    return typer.Option(
        "--env",
        "-e",
        help="Environment id; repeatable where a command takes several.",
        show_default=default,
        autocompletion=completion.environments,
    )


def _baseline(default: str | bool) -> Any:
    return typer.Option(
        "--baseline",
        "-b",
        help="Controller, or your own as path/to/file.py:Name or package.module:Name; repeatable where a "
        "command takes several.",
        show_default=default,
        autocompletion=completion.controllers,
    )


def _output(default: str | bool) -> Any:
    return typer.Option(
        "--output",
        "-o",
        help="Path to which the command writes: a folder, or a file where it writes one; used as it is.",
        show_default=default,
    )


def _action_mode(default: str | bool) -> Any:
    return typer.Option(
        "--action-mode",
        "-m",
        help="Action mode of the agent.",
        show_default=default,
        autocompletion=completion.action_modes,
    )


_GAINS: Any = typer.Option(
    "--gains",
    "-g",
    help="Gains of the controllers, also those from which a search starts: the name of a gain set, or a TOML "
    "file of settings.",
    show_default="tuned",
    autocompletion=completion.gain_sets,
)
_BUDGET: Any = typer.Option(
    "--budget", help="Control steps to simulate at most in a search, of all environments together."
)
_CONTROL_FREQUENCY: Any = typer.Option("--control-frequency", help="Control frequency [Hz].")
_SEED: Any = typer.Option(
    "--seed", help="Random seed: of the first episode, of a search, or of the training that was done."
)

Plugins = Annotated[
    list[str] | None,
    typer.Option(
        "--plugin",
        "-p",
        help="Module that declares tasks, controllers or the like and is not installed as a plugin, also one "
        "of the current folder; repeatable.",
        callback=_load,
        is_eager=True,  # names that a plugin declares may stand in other options
    ),
]
EnvironmentArgument = Annotated[
    str, typer.Argument(help="Environment id.", autocompletion=completion.environments)
]
Environments = Annotated[list[str] | None, _env("all")]
OneEnvironment = Annotated[list[str], _env(False)]
ControllerNames = Annotated[list[str] | None, _baseline("all")]
OneController = Annotated[list[str] | None, _baseline(False)]
Scenarios = Annotated[
    list[str],
    typer.Option(
        "--scenario",
        "-s",
        help="Scenario; repeatable where a command takes several.",
        autocompletion=completion.scenarios,
    ),
]
AgentPaths = Annotated[
    list[Path] | None,
    typer.Option(
        "--agent",
        "-a",
        help="Agent: the path of its files, or its name if it comes with the suite. Repeatable where a "
        "command takes several; these are paths, also of a folder with one agent for each training seed.",
    ),
]
Episodes = Annotated[
    int,
    typer.Option("--episodes", "-n", help="Episodes of a policy, or of a candidate of a search."),
]
Seed = Annotated[int, _SEED]
KnownSeed = Annotated[int | None, _SEED]
Gains = Annotated[str, _GAINS]
StartGains = Annotated[str | None, _GAINS]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help="name=value in place of a setting of the controllers' gains, with a value in TOML as in "
        "stiffness=200, or of a recipe, with a value in YAML as in gamma=0.98; repeatable.",
    ),
]
ControlFrequency = Annotated[float, _CONTROL_FREQUENCY]
KnownControlFrequency = Annotated[float | None, _CONTROL_FREQUENCY]
Budget = Annotated[int | None, _BUDGET]
Engine = Annotated[str, _engine(True)]
EngineOfRecipe = Annotated[str | None, _engine(f"{MUJOCO}, or that of the recipe")]
Output = Annotated[Path, _output(True)]
RunOutput = Annotated[Path | None, _output("a new folder in results")]
OutputOfPackage = Annotated[Path | None, _output("that of the package")]
RunName = Annotated[
    str,
    typer.Option(
        "--name", help="Name that is added to the date and time of the default folder.", show_default=False
    ),
]
ParallelWorkers = Annotated[
    int,
    typer.Option(
        "--jobs",
        "-j",
        help="Parallel workers; 1: this process alone, 0: as many as there are cores. "
        "Compute times are those of a busy machine unless 1.",
    ),
]
Backend = Annotated[
    str,
    typer.Option(
        "--backend",
        help="loky: processes; ray: the cluster at RAY_ADDRESS, or a local one.",
        autocompletion=completion.backends,
    ),
]
Resume = Annotated[
    bool,
    typer.Option(
        "--resume/--fresh",
        help="Go on with what an interrupted run of the same command has kept, or start over.",
    ),
]
Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", help="Write nothing but results and errors.", show_default=False)
]
Json = Annotated[
    bool,
    typer.Option(
        "--json",
        help="Write the results, with the tables if there are any, as one JSON document.",
        show_default=False,
    ),
]
TableFormat = Annotated[
    str,
    typer.Option(
        "--format",
        "-f",
        help=f"Form of the tables: {', '.join(FORMATS)}. With any but {TERMINAL}, they alone go to standard "
        "output; json is the same as --json.",
        callback=_check_format,
        autocompletion=completion.table_formats,
    ),
]
FigureFormat = Annotated[
    str,
    typer.Option(
        "--figure-format",
        help=f"Kind of the figures: {', '.join(_KINDS)}; the last two are vector graphics, for papers.",
        callback=_check_figure_format,
        autocompletion=completion.figure_formats,
    ),
]
Algorithm = Annotated[
    str,
    typer.Option(
        "--algo",
        "--algorithm",
        help=f"Learning algorithm: {', '.join(ALGORITHMS)}.",
        autocompletion=completion.algorithms,
    ),
]
ActionMode = Annotated[str, _action_mode(True)]
KnownActionMode = Annotated[str | None, _action_mode("torque, or that of the agent")]
DefaultActionMode = Annotated[
    str | None, _action_mode("that of the shipped agents, or of the recipes of --config")
]
RecipeFile = Annotated[
    Path | None,
    typer.Option("--config", help="Recipes in YAML, in place of those that come with the suite."),
]
Manifest = Annotated[
    Path | None,
    typer.Option(
        "--manifest", help="List of the shipped agents in YAML, in place of that which comes with the suite."
    ),
]


def only(option: str, values: Sequence[str] | None) -> str:
    """The value of an option that a command takes once.

    Args:
        option: name of the option, for the message.
        values: what was given.

    Raises:
        InvalidValueError: none or several.
    """
    given = at_most_one(option, values)
    if given is None:
        raise InvalidValueError(option, [], "exactly one for this command")
    return given


def at_most_one(option: str, values: Sequence[str] | None) -> str | None:
    """The value of an option that a command takes once or not at all.

    Args:
        option: name of the option, for the message.
        values: what was given.

    Raises:
        InvalidValueError: several.
    """
    given = list(dict.fromkeys(values or []))
    if len(given) > 1:
        raise InvalidValueError(option, given, "exactly one for this command")
    return given[0] if given else None
