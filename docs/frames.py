"""Frames of simulations and of a video for the documentation: `make frames`.

Pixels depend on the machine's OpenGL, so that no test compares them.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import gymnasium
import numpy as np
from PIL import Image
from typer.testing import CliRunner

import prp_gym
from docs.colour_vision import simulate
from prp_gym.cli.main import app

FOLDER = Path(__file__).parent / "images"
SIZE = (640, 480)
_DRAWN = (960, 720)  # and then reduced to SIZE
_COLORS = 255


class Shot(NamedTuple):
    """A frame of an episode.

    Attributes:
        name: Name of the image.
        environment_id: Id of the environment.
        controller: Name of the controller.
        scenario: Name of the scenario.
        seed: Random seed of the episode.
        seconds: Time in the episode [s].
        camera: Name of the camera.
    """

    name: str
    environment_id: str
    controller: str
    scenario: str
    seed: int
    seconds: float
    camera: str = "task"


SHOTS = (
    Shot("overview", "PRP-JointTracking-v0", "joint_pd", "realistic", 3, 0.7),
    Shot("top", "PRP-JointTracking-v0", "joint_inverse_dynamics", "randomized", 7, 0.7, "top"),
    Shot("pose", "PRP-PoseTracking-v0", "operational_inverse_dynamics", "report", 0, 1.5),
    Shot("contact", "PRP-Impedance-v0", "impedance", "report", 0, 1.2),
    Shot("force", "PRP-ForcePosition-v0", "parallel_force_position", "randomized", 5, 1.3),
    Shot("soft_surface", "PRP-Force-v0", "force_inner_position", "report", 0, 1.0),
)
SEEN = ("force", "overview")
"""Images that are also shown as readers with deuteranopia see them."""

VIDEO = (
    *("record", "PRP-Force-v0", "--baseline", "force_inner_position", "--vs", "impedance"),
    *("--seed", "5", "--duration", "1.0", "--fps", "2", "--size", "960x540"),
)
MOVING = (
    *("record", "PRP-ForcePosition-v0", "--baseline", "parallel_force_position", "--vs", "force_feedforward"),
    *("--scenario", "realistic", "--seed", "5", "--duration", "3.0", "--fps", "10", "--size", "960x400"),
)
"""README's animation."""


def main() -> None:
    """Write every image."""
    FOLDER.mkdir(exist_ok=True)
    for shot in SHOTS:
        frame = draw(shot)
        save(frame, shot.name)
        if shot.name in SEEN:
            save(Image.fromarray(simulate(np.asarray(frame))), f"{shot.name}_deuteranopia")
    with TemporaryDirectory() as folder:
        output = Path(folder) / "frames"
        CliRunner().invoke(app, [*VIDEO, "--output", str(output)], catch_exceptions=False)
        with Image.open(sorted(output.iterdir())[-1]) as last:
            save(last.copy(), "record")
    moving = FOLDER / "force.gif"
    moving.unlink(missing_ok=True)
    CliRunner().invoke(app, [*MOVING, "--output", str(moving)], catch_exceptions=False)


def draw(shot: Shot) -> Image.Image:
    """The frame, reduced to its size."""
    env = gymnasium.make(
        shot.environment_id,
        scenario=shot.scenario,
        render_mode="rgb_array",
        camera=shot.camera,
        width=_DRAWN[0],
        height=_DRAWN[1],
    )
    policy = prp_gym.make_baseline(shot.controller, env)
    observation, state = env.reset(seed=shot.seed)[0], None
    for _ in range(round(shot.seconds * 500)):
        action, state = policy.predict(observation, state)
        observation, *_ = env.step(action)
    frame = Image.fromarray(np.asarray(env.render()))
    env.close()
    return frame.resize(SIZE, Image.Resampling.LANCZOS)


def save(image: Image.Image, name: str) -> None:
    """Write an image with a palette of its own."""
    image.quantize(_COLORS).save(FOLDER / f"{name}.png", optimize=True)


if __name__ == "__main__":
    main()
