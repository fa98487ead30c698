"""Small agents in files, for comparisons: random networks with a training that nobody did."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from prp_gym.agents.policy.agent_card import CurvePoint
from prp_gym.agents.policy.agent_file import save_agent
from prp_gym.agents.policy.learned_policy import LearnedPolicy
from prp_gym.agents.policy.network import Network
from tests.support.synthetic_agents import RUN, synthetic_policy

CURVE = (
    CurvePoint(1000, 6.0, 0.05, {"joint_stop": 2.0}),
    CurvePoint(2000, 12.0, 0.999, {"joint_stop": 2.0, "divergences": 1.0}),
)
KEYWORDS: dict[str, Any] = {"scenario": "randomized", "action_mode": "torque", "control_frequency": 50.0}
GAIN = np.float32(0.05)  # of the last layer: with random torques as large as they may be, an episode diverges


def save(
    stem: Path,
    seed: int = 0,
    environment_id: str = "PRP-JointTracking-v0",
    network: int | None = None,
    **keywords: Any,
) -> Path:
    """Write an agent's two files; the path without suffix.

    Args:
        stem: the path without suffix.
        seed: seed of the training, and of the network's random numbers unless `network` is given.
        environment_id: id of the agent's environment.
        network: seed of the network's random numbers.
        keywords: keywords of the environment that differ from `KEYWORDS`.
    """
    policy = synthetic_policy(
        seed=seed if network is None else network,
        environment_id=environment_id,
        keywords={**KEYWORDS, **keywords},
        run=replace(RUN, seed=seed, curve=CURVE),
    )
    shape, tensors = policy.network.shape, policy.network.tensors
    last = f"layer_{len(shape.hidden)}."
    mild = {name: tensors[name] * GAIN if name.startswith(last) else tensors[name] for name in tensors}
    save_agent(LearnedPolicy(policy.card, policy.normalizer, Network(shape, mild)), stem)
    return stem
