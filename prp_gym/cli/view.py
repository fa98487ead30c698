"""The command `prp-gym view`."""

from typing import Annotated

import typer

from prp_gym.checks import choice
from prp_gym.cli.one_policy import name_agent, name_controller, name_scenario
from prp_gym.cli.options import (
    AgentPaths,
    EnvironmentArgument,
    Gains,
    KnownActionMode,
    KnownControlFrequency,
    OneController,
    Plugins,
    Scenarios,
    Seed,
    Settings,
)
from prp_gym.console.terminal import Terminal
from prp_gym.envs.action_mode import TORQUE
from prp_gym.errors import InvalidValueError
from prp_gym.physics.rendering import has_display
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.selection import Selection
from prp_gym.tasks.registration import list_envs
from prp_gym.viewing.agent_source import AgentSource
from prp_gym.viewing.controller_source import ControllerSource
from prp_gym.viewing.inner_controller_source import InnerControllerSource
from prp_gym.viewing.policy_catalogue import PolicyCatalogue
from prp_gym.viewing.policy_source import PolicySource
from prp_gym.viewing.session import Session
from prp_gym.viewing.viewer import Viewer
from prp_gym.viewing.web.server import serving

_DEFAULT_SCENARIOS = ["randomized"]
_FREQUENCY = 500.0  # Hz, of controllers


def view_command(
    context: typer.Context,
    env: EnvironmentArgument,
    baseline: OneController = None,
    agent: AgentPaths = None,
    scenario: Scenarios = _DEFAULT_SCENARIOS,
    seed: Seed = 0,
    gains: Gains = TUNED,
    settings: Settings = None,
    action_mode: KnownActionMode = None,
    control_frequency: KnownControlFrequency = None,
    web: Annotated[
        bool, typer.Option("--web", help="Show a page in the browser also where there is a display.")
    ] = False,
    host: Annotated[
        str,
        typer.Option(help="Address of the page; 127.0.0.1: for this machine, 0.0.0.0: for the network."),
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port of the page; 0: any that is free.")] = 8080,
    plugin: Plugins = None,
) -> None:
    """Watch a controller or an agent while it runs, and change it.

    Where there is a display a window of MuJoCo's viewer opens. With `--web`, and where there is none, a page
    in the browser shows the arm with live plots, and has controls for the gains, the surface, the scenario
    and a disturbance.

    The policy is the first controller that is meant for the environment, unless one or an agent is named;
    with --action-mode it is the inner controller of the mode, whose actions are zero. Controllers act at 500
    Hz unless --control-frequency says otherwise, agents at that of their training.
    """
    choice("environment", env, list_envs())
    condition = name_scenario(scenario)
    trained = name_agent(agent)
    controller = name_controller(context, env, baseline, agent)
    frequency = control_frequency or _FREQUENCY
    if trained is not None:
        source = _agent(env, trained, action_mode, control_frequency)
    elif action_mode in (None, TORQUE):
        selected = Selection.of([env], [], [str(controller)], GainsChoice.read(gains, settings or ()))
        source = ControllerSource(selected.controllers, selected.choices[0], env, frequency)
    elif baseline:
        raise InvalidValueError("--action-mode beside --baseline", action_mode, repr(TORQUE))
    else:
        source = InnerControllerSource(env, str(action_mode), frequency)
    session = Session(source, condition, seed)
    try:
        if web or not has_display():
            _show_page(Viewer(session), PolicyCatalogue(env, frequency, source), host, port)
        else:
            _show_window(Viewer(session))
    finally:
        session.close()


def _agent(env: str, name: str, action_mode: str | None, frequency: float | None) -> PolicySource:
    """The source of an agent, whose action mode and control frequency are those of its training.

    Raises:
        PRPError: an agent that does not exist, of another environment, or of another mode or frequency.
    """
    source = AgentSource(name, env)
    if action_mode not in (None, source.action_mode):
        raise InvalidValueError("action mode of the agent", action_mode, repr(source.action_mode))
    if frequency not in (None, source.control_frequency):
        allowed = f"{source.control_frequency:g}"
        raise InvalidValueError("control frequency of the agent", frequency, allowed, "Hz")
    return source


def _show_page(viewer: Viewer, catalogue: PolicyCatalogue, host: str, port: int) -> None:
    """Serve the page until the command is interrupted."""
    environment_id = viewer.session.inner.task.environment_id
    with serving(host, port, f"prp_gym: {environment_id}") as server:
        from prp_gym.viewing.web.page import Page

        page = Page(server, viewer, catalogue)
        address = f"http://{host}:{server.get_port()}"
        _say(f"{address} shows {environment_id}. Ctrl-C ends.")
        viewer.run(page)


def _show_window(viewer: Viewer) -> None:
    """Show a window until it is closed."""
    from prp_gym.viewing.window import KEYS, Window

    window = Window(viewer, _say)
    try:
        _say(KEYS)
        viewer.run(window)
    finally:
        window.close()


def _say(text: str) -> None:
    """Tell the user something while the session runs."""
    Terminal().report({}, lines=[text])
