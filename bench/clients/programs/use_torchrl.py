"""TorchRL: one environment with the numbers of `info`, two in processes, and a native vector environment."""

import gymnasium
from torchrl.envs import GymEnv, GymWrapper, check_env_specs

import prp_gym  # noqa: F401 (registers the environments)

if __name__ == "__main__":  # the processes import this file
    environment = GymEnv("PRP-Force-v0", scenario="randomized", frame_skip=2)
    environment.auto_register_info_dict()  # reads every number of `info`
    check_env_specs(environment)
    print(environment.rollout(100)["next", "contact_force"].shape)

    processes = GymEnv("prp_gym:PRP-Force-v0", num_envs=2)
    check_env_specs(processes)
    processes.close()

    together = GymWrapper(gymnasium.make_vec("PRP-Force-v0", num_envs=8, autoreset_mode="Disabled"))
    check_env_specs(together)
    print(together.rollout(100)["next", "reward"].shape)
