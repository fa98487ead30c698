"""The command `prp-gym record`."""

from collections.abc import Iterator
from contextlib import ExitStack
from typing import Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from prp_gym.checks import choice, random_seed
from prp_gym.cli.one_policy import name_agent, name_controller, name_scenario
from prp_gym.cli.options import (
    AgentPaths,
    ControlFrequency,
    EnvironmentArgument,
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
from prp_gym.console.progress import Progress
from prp_gym.console.terminal import Terminal
from prp_gym.envs.config import EnvConfig
from prp_gym.recording.composer import Composer
from prp_gym.recording.side import Side
from prp_gym.recording.video import Video, video_name
from prp_gym.recording.video_file import check_output, write_video
from prp_gym.runs.acting_policy import ActingPolicy
from prp_gym.runs.choice import TUNED, GainsChoice
from prp_gym.runs.result_folder import ResultFolder
from prp_gym.tasks.presets import find_preset
from prp_gym.tasks.registration import list_envs

_DEFAULT_SCENARIOS = ["randomized"]


def record_command(
    context: typer.Context,
    env: EnvironmentArgument,
    baseline: OneController = None,
    agent: AgentPaths = None,
    vs: Annotated[
        str | None,
        typer.Option(help="Controller or agent beside the first one, on the same seed, with its own gains."),
    ] = None,
    scenario: Scenarios = _DEFAULT_SCENARIOS,
    seed: Seed = 0,
    gains: Gains = TUNED,
    settings: Settings = None,
    control_frequency: ControlFrequency = 500.0,
    duration: Annotated[float, typer.Option(help="Duration of the episode [s].")] = 5.0,
    slow: Annotated[float, typer.Option(help="Factor by which the video is slower than the episode.")] = 1.0,
    size: Annotated[str, typer.Option(help="Size of the video, WIDTHxHEIGHT [pixels].")] = "1280x720",
    fps: Annotated[int, typer.Option(help="Frames per second; a divisor of 100 for a gif.")] = 25,
    camera: Annotated[str, typer.Option(help="Camera: task, contact, overview or top.")] = EnvConfig.camera,
    output: RunOutput = None,
    name: RunName = "",
    quiet: Quiet = False,
    as_json: Json = False,
    plugin: Plugins = None,
) -> None:
    """Record a video of an episode, with force and error as numbers and as charts that run with the time.

    The policy is the first controller that is meant for the environment, unless one or an agent is named. Two
    policies beside each other see the same episode: the same start, reference, surface and disturbances.
    --output is the video, .mp4 or .gif, or a folder for frames; by default it is an mp4.
    """
    video = Video.of(size, fps, slow)
    random_seed("--seed", seed)
    choice("environment", find_preset(env).task.id, list_envs())
    condition = name_scenario(scenario)
    controller, trained = name_controller(context, env, baseline, agent), name_agent(agent)
    names = [str(trained or controller), *([] if vs is None else [vs])]
    own_name = video_name(env, names, condition, seed)
    check_output(output or own_name, video.width, video.height, video.fps)
    title = f"{env}   scenario {condition}   seed {seed}" + (
        "" if slow == 1.0 else f"   {slow:g} times slower"
    )
    composer = Composer(video.width, video.height, len(names), title, duration)
    keywords = {"scenario": condition, "control_frequency": control_frequency, "duration": duration}
    keywords |= {"render_mode": "rgb_array", "camera": camera}
    keywords |= dict(zip(("width", "height"), composer.frame_size, strict=True))
    terminal, count = Terminal.of(quiet, as_json), video.count(duration)
    with ExitStack() as opened:
        chosen = GainsChoice.read(gains, settings or ())
        sides = [_first(controller, names[0], chosen, env, keywords)]
        opened.callback(sides[0].env.close)
        if vs is not None:
            sides.append(ActingPolicy.of_name(vs, env, keywords))
            opened.callback(sides[1].env.close)
        frames = video.frames([Side(side, seed) for side in sides], composer, duration)
        folder = ResultFolder.choose("record", output, name, [], goes_on=False)
        path = folder.path if output is not None else folder.path / own_name
        with folder.in_use(), terminal.progress("recording", count, "frames") as progress:
            write_video(path, _counted(frames, progress), (video.width, video.height), video.fps)
    seconds = count / video.fps
    content = {"video": str(path), "frames": count, "width": video.width, "height": video.height}
    content |= {"seconds": seconds, "policies": [side.name for side in sides]}
    told = f"video: {path} ({count} frames, {video.width}x{video.height}, {seconds:.2f} s)"
    terminal.report(content, lines=[told])


def _first(
    controller: str | None, name: str, gains: GainsChoice, env: str, keywords: dict[str, Any]
) -> ActingPolicy:
    """The policy that `--baseline` or `--agent` names."""
    if controller is None:
        return ActingPolicy.of_agent(name, env, keywords)
    return ActingPolicy.of_controller(controller, gains, env, keywords)


def _counted(frames: Iterator[NDArray[np.uint8]], progress: Progress) -> Iterator[NDArray[np.uint8]]:
    """The frames, each of which is told to the progress."""
    for image in frames:
        yield image
        progress.advance(1)
