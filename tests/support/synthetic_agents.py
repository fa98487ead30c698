"""Agents that nobody trained: random networks in numpy, and random models of Stable-Baselines3."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.wrappers import TransformObservation
from numpy.typing import NDArray

import prp_gym  # noqa: F401 (registers the environments)
from prp_gym.agents.policy.agent_card import AgentCard, CurvePoint, Interface, Part, Score, TrainingRecord
from prp_gym.agents.policy.features import TrackingFeatures
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.agents.policy.network import Network, NetworkShape
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.agents.training.export import AgentFacts
from prp_gym.tasks.fields import ObservationLayout

ID = "PRP-JointTracking-v0"  # observes a reference, so that tracking errors are among the features
KEYWORDS: dict[str, Any] = {"scenario": "realistic", "action_mode": "torque", "control_frequency": 50}
RUN = TrainingRecord(
    command="prp-gym train PRP-JointTracking-v0 --algo ppo",
    seed=3,
    steps=2_000,
    seconds=12.5,
    hyperparameters={
        "learning_rate": 3e-7,
        "net_arch": [8, 8],
        "use_sde": False,
        "target_kl": None,
        "name": "ä",
    },
    curve=(
        CurvePoint(1_000, 6.0, 0.25, {"joint_stop": 4.0}),
        CurvePoint(2_000, 12.5, 0.5, {"joint_stop": 4.5, "divergences": 1.0}),
    ),
)


@cache
def spaces_of(environment_id: str, action_mode: str = "torque") -> tuple[ObservationLayout, int]:
    """The observation's layout, and the size of an action."""
    env = gymnasium.make(environment_id, action_mode=action_mode)
    layout: ObservationLayout = env.get_wrapper_attr("observation_layout")
    (size,) = env.action_space.shape or ()
    env.close()
    return layout, size


def layout_of(environment_id: str) -> ObservationLayout:
    return spaces_of(environment_id)[0]


def score(value: float) -> Score:
    return Score(value, value - 0.01, value + 0.01, 20, 0)


def synthetic_policy(
    scores: Mapping[str, float] | None = None,
    memory: tuple[int, ...] = (),
    seed: int = 0,
    environment_id: str = ID,
    keywords: Mapping[str, Any] = KEYWORDS,
    run: TrainingRecord = RUN,
) -> LearnedPolicy:
    """A policy of tracking features with a random network, drawn by `seed`, of one hidden layer of 4."""
    rng = np.random.default_rng(seed)
    layout, outputs = spaces_of(environment_id, keywords["action_mode"])
    features = TrackingFeatures(layout)
    shape = NetworkShape(features.size, memory, (4,), outputs, "tanh", "clip")
    tensors = {
        name: rng.normal(scale=0.3, size=size).astype(np.float32)
        for name, size in shape.tensor_shapes().items()
    }
    observation = tuple(Part(part.name, part.shape[0]) for part in layout.fields)
    action = tuple(Part(name, size) for name, size in (("near", 1), ("far", outputs - 1)) if size)
    card = AgentCard(
        interface=Interface(environment_id, keywords, observation, features.names, action),
        algorithm="RecurrentPPO" if memory else "PPO",
        network=shape,
        run=run,
        scores={name: score(value) for name, value in (scores or {}).items()},
        versions={"python": "3.11.0"},
        sha256="",
    )
    normalizer = Normalizer(rng.normal(size=features.size), rng.uniform(0.5, 2.0, features.size), 1e-8, 10.0)
    return LearnedPolicy(card, normalizer, Network(shape, tensors))


def observations(count: int, seed: int = 0, environment_id: str = ID) -> NDArray[np.float64]:
    """Random ones (count, size), some so far out that their normalised features are clipped."""
    return np.random.default_rng(seed).normal(scale=2.0, size=(count, layout_of(environment_id).size))


@dataclass(frozen=True, eq=False)
class Trained:
    """What a training with Stable-Baselines3 ends with.

    Attributes:
        model: Stable-Baselines3 model with random weights.
        wrapper: VecNormalize of the model, with statistics, epsilon and clip other than the defaults.
        features: function that maps observations to the inputs of the model in training.
    """

    model: Any
    wrapper: Any
    features: Any

    @property
    def normalizer(self) -> Normalizer:
        statistics = self.wrapper.obs_rms
        return Normalizer(statistics.mean, statistics.var, self.wrapper.epsilon, self.wrapper.clip_obs)

    def expected(self, observation: Any, state: Any = None, start: Any = None) -> tuple[Any, Any]:
        """What Stable-Baselines3 itself answers to an observation of the environment."""
        given = self.wrapper.normalize_obs(self.features(observation))
        answer: tuple[Any, Any] = self.model.predict(given, state, episode_start=start, deterministic=True)
        return answer


def facts(environment_id: str = ID) -> AgentFacts:
    return AgentFacts(environment_id, KEYWORDS, layout_of(environment_id), RUN)


def trained(
    algorithm: str = "PPO", tracking: bool = True, environment_id: str = ID, **policy_keywords: Any
) -> Trained:
    """A model with random weights on normalised features."""
    import sb3_contrib
    import stable_baselines3
    import torch
    from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

    features = TrackingFeatures(layout_of(environment_id)) if tracking else np.asarray
    size = features.size if isinstance(features, TrackingFeatures) else layout_of(environment_id).size
    space = Box(-np.inf, np.inf, (size,), np.float64)
    wrapper = VecNormalize(
        DummyVecEnv(
            [lambda: TransformObservation(gymnasium.make(environment_id, **KEYWORDS), features, space)]
        ),
        training=False,
        clip_obs=1.5,
        epsilon=0.25,
    )
    rng = np.random.default_rng(5)
    assert not isinstance(wrapper.obs_rms, dict)
    wrapper.obs_rms.mean = rng.normal(size=size)
    wrapper.obs_rms.var = np.exp(rng.normal(size=size))
    kind = getattr(stable_baselines3, algorithm, None) or getattr(sb3_contrib, algorithm)
    policy = "MlpLstmPolicy" if algorithm == "RecurrentPPO" else "MlpPolicy"
    off_policy = {} if algorithm.endswith("PPO") else {"buffer_size": 10}
    with torch.random.fork_rng():
        model = kind(
            policy,
            wrapper,
            seed=7,
            device="cpu",
            policy_kwargs={"net_arch": [16, 12], **policy_keywords},
            **off_policy,
        )
        for parameter in model.policy.parameters():
            torch.nn.init.normal_(parameter, std=0.25)
    return Trained(model, wrapper, features)
