"""PufferLib: its emulation of an environment, two in a row, and two in processes."""

from typing import Any

import gymnasium
import pufferlib.emulation
import pufferlib.vector

import prp_gym  # noqa: F401 (registers the environments)


def make(buf: Any = None, seed: int = 0) -> pufferlib.emulation.GymnasiumPufferEnv:
    """Make one environment in PufferLib's form."""
    env = gymnasium.make("PRP-Force-v0", duration=0.1)
    return pufferlib.emulation.GymnasiumPufferEnv(env=env, buf=buf, seed=seed)


if __name__ == "__main__":  # the processes import this file
    for backend in (pufferlib.vector.Serial, pufferlib.vector.Multiprocessing):
        together = pufferlib.vector.make(make, num_envs=2, backend=backend)
        together.reset(seed=1)
        for _ in range(120):
            observation, reward, terminated, truncated, infos = together.step(together.action_space.sample())
        print(observation.shape, reward.sum())
        together.close()
