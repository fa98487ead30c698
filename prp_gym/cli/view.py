"""The command `prp-gym view`."""

from typing import Annotated

import typer

from prp_gym.baselines import CONTROLLERS, list_baselines
from prp_gym.checks import choice
from prp_gym.cli.options import FirstSeed, Gains, Plugins, Settings
from prp_gym.envs.action_mode import TORQUE
from prp_gym.errors import InvalidValueError
from prp_gym.physics.rendering import has_display
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.selection import Selection
from prp_gym.runs.terminal import make_console
from prp_gym.tasks.registration import list_envs
from prp_gym.viewing.agent_source import AgentSource
from prp_gym.viewing.controller_source import ControllerSource
from prp_gym.viewing.inner_controller_source import InnerControllerSource
from prp_gym.viewing.policy_catalogue import PolicyCatalogue
from prp_gym.viewing.policy_source import PolicySource
from prp_gym.viewing.session import Session
from prp_gym.viewing.viewer import Viewer
from prp_gym.viewing.web.server import serving

_FREQUENCY = 500.0  # Hz, of controllers


def view_command(
    env: Annotated[str, typer.Argument(help="Environment id.")],
    baseline: Annotated[
        str | None,
        typer.Option(
            help="Controller, or your own as path/to/file.py:Name or package.module:Name."
            " Default: the first one that is meant for the environment."
        ),
    ] = None,
    agent: Annotated[
        str | None, typer.Option(help="Trained agent: its name, or the path of its files.")
    ] = None,
    scenario: Annotated[str, typer.Option(help="Scenario.")] = "randomized",
    seed: FirstSeed = 0,
    gains: Gains = TUNED,
    settings: Settings = None,
    action_mode: Annotated[
        str | None,
        typer.Option(
            help="Action mode, with zero actions for its inner controller. Default: torque, or the agent's."
        ),
    ] = None,
    control_frequency: Annotated[
        float | None, typer.Option(help="Control frequency [Hz]. Default: 500, or that of the agent.")
    ] = None,
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
    """
    choice("environment", env, list_envs())
    if agent is None:
        chosen = GainsChoice.read(gains, settings or ())
        source = _controller(env, baseline, chosen, action_mode or TORQUE, control_frequency or _FREQUENCY)
    elif baseline is not None:
        raise InvalidValueError("--agent beside --baseline", agent, "one of the two")
    else:
        source = _agent(env, agent, action_mode, control_frequency)
    session = Session(source, scenario, seed)
    try:
        if web or not has_display():
            catalogue = PolicyCatalogue(env, control_frequency or _FREQUENCY, source)
            _show_page(Viewer(session), catalogue, host, port)
        else:
            _show_window(Viewer(session))
    finally:
        session.close()


def _controller(
    env: str, baseline: str | None, gains: GainsChoice, action_mode: str, frequency: float
) -> PolicySource:
    """The source of a controller: the one that is named, that of an action mode, or the first that is meant.

    Raises:
        PRPError: a name that does not exist, or a controller beside an action mode.
    """
    if action_mode != TORQUE:
        if baseline is not None:
            raise InvalidValueError("--action-mode beside --baseline", action_mode, "'torque'")
        return InnerControllerSource(env, action_mode, frequency)
    name = baseline or _first_intended(env, frequency)
    selected = Selection.of([env], [], [name], gains)
    return ControllerSource(selected.controllers, selected.choices[0], env, frequency)


def _first_intended(env: str, frequency: float) -> str:
    """The first controller that is meant for an environment, or else the first that runs on it."""
    for name, spec in CONTROLLERS.items():
        if env in spec.data.intended:
            return name
    made = InnerControllerSource(env, TORQUE, frequency).make_env("report")
    return list_baselines(made.get_wrapper_attr("observation_layout"))[0]


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
        make_console().print(f"{address} shows {environment_id}. Ctrl-C ends.", highlight=False)
        viewer.run(page)


def _show_window(viewer: Viewer) -> None:
    """Show a window until it is closed."""
    from prp_gym.viewing.window import KEYS, Window

    console = make_console()
    window = Window(viewer, lambda text: console.print(text, markup=False, highlight=False))
    try:
        console.print(KEYS, highlight=False)
        viewer.run(window)
    finally:
        window.close()
