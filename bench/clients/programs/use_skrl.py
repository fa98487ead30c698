"""skrl: PPO on one environment, and on eight that are stepped together."""

from typing import Any

import gymnasium
from skrl.agents.torch.ppo import PPO, PPO_CFG
from skrl.envs.wrappers.torch import wrap_env
from skrl.memories.torch import RandomMemory
from skrl.trainers.torch import SequentialTrainer
from skrl.utils.model_instantiators.torch import deterministic_model, gaussian_model

import prp_gym  # noqa: F401 (registers the environments)

LAYERS = [{"name": "net", "input": "OBSERVATIONS", "layers": [64, 64], "activations": "tanh"}]


def train(env: Any) -> None:
    """Train for two batches."""
    wrapped = wrap_env(env)
    spaces = {"observation_space": wrapped.observation_space, "action_space": wrapped.action_space}
    models = {
        "policy": gaussian_model(**spaces, network=LAYERS, output="ACTIONS"),
        "value": deterministic_model(**spaces, network=LAYERS, output="ONE"),
    }
    memory = RandomMemory(memory_size=32, num_envs=wrapped.num_envs)
    agent = PPO(models=models, memory=memory, cfg=PPO_CFG(rollouts=32), **spaces)
    SequentialTrainer(env=wrapped, agents=agent, cfg={"timesteps": 64, "headless": True}).train()


train(gymnasium.make("PRP-Force-v0"))
train(gymnasium.make_vec("PRP-Force-v0", num_envs=8))
