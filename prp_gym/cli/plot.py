"""The command `prp-gym plot`."""

from contextlib import closing
from pathlib import Path

import typer

from prp_gym.checks import choice, random_seed
from prp_gym.cli.one_policy import name_agent, name_controller, name_scenario, refuse
from prp_gym.cli.options import (
    AgentPaths,
    ControlFrequency,
    EnvironmentArgument,
    FigureFormat,
    Gains,
    Json,
    OneController,
    Plugins,
    Quiet,
    RunName,
    RunOutput,
    Scenarios,
    Seed,
    Settings,
)
from prp_gym.console.terminal import Terminal
from prp_gym.evaluation.episode import record_episode
from prp_gym.evaluation.rollout import Rollout
from prp_gym.figures.figure_file import check_suffix, write_figure
from prp_gym.runs.acting_policy import ActingPolicy
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.tasks.registration import list_envs

_DEFAULT_SCENARIOS = ["realistic"]


def plot_command(
    context: typer.Context,
    env: EnvironmentArgument,
    baseline: OneController = None,
    agent: AgentPaths = None,
    scenario: Scenarios = _DEFAULT_SCENARIOS,
    seed: Seed = 0,
    gains: Gains = TUNED,
    settings: Settings = None,
    control_frequency: ControlFrequency = 500.0,
    output: RunOutput = None,
    name: RunName = "",
    figure_format: FigureFormat = "png",
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Run one episode and draw it: motion, errors, torques with their limits, contact force and reward.

    The policy is the first controller that is meant for the environment, unless one or an agent is named.
    --output is the file of the figure, whose suffix says its kind: .png, .svg or .pdf.
    """
    choice("environment", env, list_envs())
    condition = name_scenario(scenario)
    random_seed("seed", seed)
    controller, trained = name_controller(context, env, baseline, agent), name_agent(agent)
    if output is not None:
        check_suffix(output)
    terminal = Terminal.of(quiet, as_json)
    with terminal.progress("running the episode"):
        if controller is None:
            refuse(context, ("control_frequency",))
            acting = ActingPolicy.of_agent(str(trained), env, {"scenario": condition})
        else:
            keywords = {"scenario": condition, "control_frequency": control_frequency}
            acting = ActingPolicy.of_controller(
                controller, GainsChoice.read(gains, settings or ()), env, keywords
            )
        rollout = _record(acting, seed)
        target = _write(rollout, acting.name, output, name, figure_format)
    content = {
        "figure": str(target),
        "environment": env,
        "scenario": condition,
        "seed": seed,
        "policy": acting.name,
        "score": rollout.score,
    }
    terminal.report(content, lines=[f"figure: {target}"])


def _record(acting: ActingPolicy, seed: int) -> Rollout:
    """Run the episode."""
    with closing(acting.env), acting.reported():
        return record_episode(acting.policy, acting.env, seed)


def _write(rollout: Rollout, policy: str, output: Path | None, name: str, kind: str) -> Path:
    """Write the figure, into a folder of its own unless a file is named."""
    figure = rollout.plot(policy)
    folder = ResultFolder.choose("plot", None if output is None else output.parent, name, [], goes_on=False)
    target = folder.path / f"figure.{kind}" if output is None else output
    with folder.in_use():
        write_figure(target, figure)
    return target
