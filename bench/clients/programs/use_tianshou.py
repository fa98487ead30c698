"""Tianshou: one epoch of PPO on two environments."""

from typing import Any

import gymnasium
from tianshou.algorithm import PPO
from tianshou.algorithm.modelfree.reinforce import ProbabilisticActorPolicy
from tianshou.algorithm.optim import AdamOptimizerFactory
from tianshou.data import Collector, CollectStats, VectorReplayBuffer
from tianshou.env import DummyVectorEnv
from tianshou.trainer import OnPolicyTrainerParams
from tianshou.utils.net.common import Net
from tianshou.utils.net.continuous import ContinuousActorProbabilistic, ContinuousCritic
from torch.distributions import Distribution, Independent, Normal

import prp_gym  # noqa: F401 (registers the environments)


def make() -> gymnasium.Env[Any, Any]:
    """Make one environment."""
    return gymnasium.make("PRP-Force-v0", duration=0.1)


def distribution(parameters: tuple[Any, Any]) -> Distribution:
    """Distribution of the actions."""
    return Independent(Normal(*parameters), 1)


env = make()
observed, acted = env.observation_space.shape, env.action_space.shape
actor = ContinuousActorProbabilistic(
    preprocess_net=Net(state_shape=observed, hidden_sizes=[64, 64]), action_shape=acted, unbounded=True
)
policy = ProbabilisticActorPolicy(actor=actor, dist_fn=distribution, action_space=env.action_space)
critic = ContinuousCritic(preprocess_net=Net(state_shape=observed, hidden_sizes=[64, 64]))
algorithm = PPO(policy=policy, critic=critic, optim=AdamOptimizerFactory(lr=3e-4))
several = DummyVectorEnv([make, make])
training = OnPolicyTrainerParams(
    training_collector=Collector[CollectStats](algorithm, several, VectorReplayBuffer(400, 2)),
    test_collector=Collector[CollectStats](algorithm, DummyVectorEnv([make])),
    max_epochs=1,
    epoch_num_steps=200,
    collection_step_num_env_steps=100,
    update_step_num_repetitions=1,
    batch_size=50,
    test_step_num_episodes=1,
)
print(algorithm.run_training(training).best_score)
