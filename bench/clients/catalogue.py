"""The libraries that `make clients` tries."""

from bench.clients.client import Client

TORCH = "torch==2.13.0"
GYMNASIUM = "gymnasium==1.4.0"

CLIENTS = (
    Client(
        "torchrl",
        "TorchRL",
        "torchrl==0.14.1",
        (TORCH, GYMNASIUM),
        "`GymEnv` with `frame_skip`, with the numbers of `info` and with `num_envs`, `GymWrapper` around a"
        " native vector environment, each through `check_env_specs`",
    ),
    Client(
        "rllib",
        "RLlib",
        "ray[rllib]==2.60.0",
        (TORCH,),
        "two iterations of PPO on the new API stack with a remote environment runner",
    ),
    Client(
        "rl_zoo3",
        "RL Baselines3 Zoo",
        "rl_zoo3==2.9.2",
        (TORCH, GYMNASIUM, "pyyaml", "requests", "pandas<3", "plotly"),
        "training, enjoying and optimising through its programs, with the suite's recipes",
    ),
    Client(
        "skrl",
        "skrl",
        "skrl[torch]==2.1.1",
        (TORCH, GYMNASIUM),
        "PPO on a single and on a vector environment",
    ),
    Client(
        "minari",
        "Minari",
        "minari[hdf5,create]==0.5.4",
        (GYMNASIUM,),
        "a dataset with `record_infos=True`, read again with its environment",
    ),
    Client(
        "sbx",
        "SBX",
        "sbx-rl==0.28.0",
        (TORCH, GYMNASIUM),
        "SAC on four environments that are stepped together",
    ),
    Client(
        "tianshou",
        "Tianshou",
        "tianshou==2.0.1",
        (TORCH, GYMNASIUM),
        "an epoch of PPO on two environments",
    ),
    Client(
        "cleanrl",
        "CleanRL",
        "",
        (GYMNASIUM,),
        "the stacks of wrappers and the vector environments of its continuous-action scripts",
        limit="the scripts are pinned to Gymnasium 0.29.1 and stop with Gymnasium 1 in every environment:"
        " `ppo_continuous_action.py` when it makes one (`TypeError: TransformObservation.__init__() missing 1"
        " required positional argument: 'observation_space'`), the others when the first episode ends"
        " (`KeyError: 'final_observation'`); the program makes their environments with Gymnasium 1",
    ),
    Client(
        "pufferlib",
        "PufferLib",
        "pufferlib-core==3.0.23",
        (TORCH, GYMNASIUM, "psutil", "nvidia-ml-py", "rich-argparse", "pyro-ppl"),
        "its emulation of environments, and its vector environment",
        limit="its wheel requires torch 2.9.0; it is installed without its requirements, beside torch 2.13.0",
        alone=True,
    ),
)
"""The libraries by the names of their programs; the docs show them in this order."""
