"""Frames of simulations for the documentation: `make frames`.

Pixels depend on the machine's OpenGL, so that no test compares them.
"""

from pathlib import Path

import gymnasium
from PIL import Image

import prp_gym

FOLDER = Path(__file__).parent / "images"
SIZE = (640, 480)
FRAMES = (
    ("overview", "PRP-JointTracking-v0", "joint_inverse_dynamics", "randomized", 7, 0.7),
    ("top", "PRP-JointTracking-v0", "joint_inverse_dynamics", "randomized", 7, 0.7),
    ("contact", "PRP-Impedance-v0", "impedance", "report", 0, 1.2),
    ("force", "PRP-ForcePosition-v0", "parallel_force_position", "randomized", 5, 2.0),
)
"""Name, environment, controller, scenario, seed, and time in the episode [s]."""


def main() -> None:
    """Render every frame; the one called `top` is seen by the camera `top`, the others by `overview`."""
    FOLDER.mkdir(exist_ok=True)
    for name, environment_id, controller, scenario, seed, seconds in FRAMES:
        width, height = SIZE
        env = gymnasium.make(
            environment_id,
            scenario=scenario,
            render_mode="rgb_array",
            camera="top" if name == "top" else "overview",
            width=width,
            height=height,
        )
        policy = prp_gym.make_baseline(controller, env)
        observation, _ = env.reset(seed=seed)
        state = None
        for _ in range(round(seconds * 500)):
            action, state = policy.predict(observation, state)
            observation, *_ = env.step(action)
        Image.fromarray(env.render()).save(FOLDER / f"{name}.png", optimize=True)  # type: ignore[arg-type]
        env.close()


if __name__ == "__main__":
    main()
