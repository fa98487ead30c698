"""The pictures of the documentation: `make pictures`.

Pixels depend on the machine's OpenGL, so that no test compares them.
"""

from pathlib import Path

import gymnasium
from PIL import Image

import prp_gym

FOLDER = Path(__file__).parent / "images"
SECONDS = 0.7


def main() -> None:
    """One picture from each camera, in the middle of a tracking episode."""
    FOLDER.mkdir(exist_ok=True)
    for camera in ("overview", "top"):
        env = gymnasium.make(
            "PRP-JointTracking-v0", render_mode="rgb_array", camera=camera, width=640, height=480
        )
        policy = prp_gym.make_baseline("joint_inverse_dynamics", env)
        observation, _ = env.reset(seed=7)
        for _ in range(round(SECONDS * 500)):
            observation, *_ = env.step(policy.predict(observation)[0])
        Image.fromarray(env.render()).save(FOLDER / f"{camera}.png", optimize=True)  # type: ignore[arg-type]
        env.close()


if __name__ == "__main__":
    main()
