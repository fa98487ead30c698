"""The command `prp-gym record`."""

import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any

import gymnasium
import numpy as np
import typer
from numpy.typing import NDArray

import prp_gym
from prp_gym.checks import random_seed
from prp_gym.cli.options import Gains, Plugins, Settings
from prp_gym.envs.config import EnvConfig
from prp_gym.errors import InvalidValueError
from prp_gym.recording.acting_policy import ActingPolicy
from prp_gym.recording.composer import Composer
from prp_gym.recording.side import Side
from prp_gym.recording.video import Video, default_output
from prp_gym.recording.video_file import check_output, write_video
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.selection import check_names
from prp_gym.runs.terminal import make_console
from prp_gym.tasks.presets import find_preset
from prp_gym.tasks.registration import list_envs
from prp_gym.tasks.scenario import SCENARIOS

_REPORT_EVERY = 10.0  # [s]


def record_command(
    env: Annotated[str, typer.Argument(help="Environment id.")],
    baseline: Annotated[
        str | None,
        typer.Option(
            help="Controller, or your own as path/to/file.py:Name or package.module:Name. Default: the first "
            "that runs on the environment."
        ),
    ] = None,
    agent: Annotated[
        str | None, typer.Option(help="Agent in place of a controller: its name or file.")
    ] = None,
    vs: Annotated[
        str | None,
        typer.Option(help="Controller or agent beside the first one, on the same seed, with its own gains."),
    ] = None,
    scenario: Annotated[str, typer.Option(help="Scenario.")] = "randomized",
    seed: Annotated[int, typer.Option(help="Seed of the episode.")] = 0,
    gains: Gains = TUNED,
    settings: Settings = None,
    control_frequency: Annotated[float, typer.Option(help="Control frequency of controllers [Hz].")] = 500.0,
    duration: Annotated[float, typer.Option(help="Duration of the episode [s].")] = 5.0,
    slow: Annotated[float, typer.Option(help="Factor by which the video is slower than the episode.")] = 1.0,
    size: Annotated[str, typer.Option(help="Size of the video, WIDTHxHEIGHT [pixels].")] = "1280x720",
    fps: Annotated[int, typer.Option(help="Frames per second; a divisor of 100 for a gif.")] = 25,
    camera: Annotated[str, typer.Option(help="Camera: task, contact, overview or top.")] = EnvConfig.camera,
    output: Annotated[
        Path | None,
        typer.Option(
            help="Video, .mp4 or .gif, or a folder for frames. Default: an mp4 named after the episode."
        ),
    ] = None,
    plugin: Plugins = None,
) -> None:
    """Record a video of an episode, with force and error as numbers and as charts that run with the time.

    Two policies beside each other see the same episode: the same start, reference, surface and disturbances.
    """
    video = Video.of(size, fps, slow)
    random_seed("--seed", seed)
    check_names("environment", [find_preset(env).task.id], list_envs())
    check_names("scenario", [scenario], list(SCENARIOS))
    if baseline is not None and agent is not None:
        raise InvalidValueError("--agent", agent, "given without --baseline; a second policy is --vs")
    names = [agent or baseline or _first_controller(env), *([] if vs is None else [vs])]
    path = output or default_output(env, names, scenario, seed)
    check_output(path, video.width, video.height, video.fps)
    title = f"{env}   scenario {scenario}   seed {seed}" + (
        "" if slow == 1.0 else f"   {slow:g} times slower"
    )
    composer = Composer(video.width, video.height, len(names), title, duration)
    width, height = composer.frame_size
    keywords: dict[str, Any] = {
        "scenario": scenario,
        "control_frequency": control_frequency,
        "duration": duration,
        "render_mode": "rgb_array",
        "width": width,
        "height": height,
        "camera": camera,
    }
    choice = GainsChoice.read(gains, settings or ())
    with ExitStack() as opened:
        sides = [_first(agent, names[0], choice, env, keywords)]
        opened.callback(sides[0].env.close)
        if vs is not None:
            sides.append(ActingPolicy.of_name(vs, env, keywords))
            opened.callback(sides[1].env.close)
        frames = video.frames([Side(side, seed) for side in sides], composer, duration)
        count = video.count(duration)
        write_video(path, _reported(frames, count), (video.width, video.height), video.fps)
    typer.echo(f"video: {path} ({count} frames, {video.width}x{video.height}, {count / video.fps:.2f} s)")


def _first_controller(environment_id: str) -> str:
    """The first controller that runs on an environment."""
    made = gymnasium.make(environment_id)
    layout = made.get_wrapper_attr("observation_layout")
    made.close()
    return prp_gym.list_baselines(layout)[0]


def _first(
    agent: str | None, name: str, gains: GainsChoice, env: str, keywords: dict[str, Any]
) -> ActingPolicy:
    """The policy that `--baseline` or `--agent` names."""
    if agent is None:
        return ActingPolicy.of_controller(name, gains, env, keywords)
    if gains != GainsChoice():
        raise InvalidValueError("--gains and --set", gains.name, "given for controllers only, not for agents")
    return ActingPolicy.of_agent(name, env, keywords)


def _reported(frames: Iterator[NDArray[np.uint8]], count: int) -> Iterator[NDArray[np.uint8]]:
    """The frames; every few seconds a line says how many there are."""
    console, last = make_console(stderr=True), time.monotonic()
    for number, image in enumerate(frames, 1):
        yield image
        if time.monotonic() - last > _REPORT_EVERY:
            last = time.monotonic()
            console.print(f"recording: {number} of {count} frames", highlight=False)
