"""The files of Stable-Baselines3, which run code when they are opened: only of authors one trusts."""

import pickle
from pathlib import Path

import numpy as np
import sb3_contrib
import stable_baselines3
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecNormalize

from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.errors import AgentFileError, UnknownNameError

_ALGORITHMS: dict[str, type[BaseAlgorithm]] = {
    "ppo": stable_baselines3.PPO,
    "recurrent_ppo": sb3_contrib.RecurrentPPO,
    "sac": stable_baselines3.SAC,
    "td3": stable_baselines3.TD3,
    "tqc": sb3_contrib.TQC,
}


def open_trusted_model(path: Path, algorithm: str) -> BaseAlgorithm:
    """A model as Stable-Baselines3 saved it; code in the file is run.

    Args:
        path: of the zip.
        algorithm: by which it was trained, in lower case.

    Raises:
        UnknownNameError: no such algorithm.
        AgentFileError: the file is not such a model.
    """
    if algorithm not in _ALGORITHMS:
        raise UnknownNameError("algorithm", algorithm, _ALGORITHMS)
    try:
        return _ALGORITHMS[algorithm].load(path, device="cpu")
    except Exception as error:  # whatever the file's content makes a reader of pickles raise
        raise AgentFileError(path, f"cannot be read as a model of {algorithm}: {error}") from error


def open_trusted_normalizer(path: Path) -> Normalizer:
    """The normaliser of a VecNormalize as it saved itself; code in the file is run.

    Raises:
        AgentFileError: the file is not such a wrapper, or not one of flat observations.
    """
    try:
        wrapper = pickle.loads(path.read_bytes())
    except Exception as error:  # whatever the file's content makes a reader of pickles raise
        raise AgentFileError(path, f"cannot be read as a VecNormalize: {error}") from error
    if not isinstance(wrapper, VecNormalize) or not wrapper.norm_obs:
        raise AgentFileError(path, "is not a VecNormalize of observations")
    statistics = wrapper.obs_rms
    if not isinstance(statistics, RunningMeanStd):
        raise AgentFileError(path, "is a VecNormalize of observations that are not flat arrays")
    mean, variance = (np.array(values, dtype=np.float64) for values in (statistics.mean, statistics.var))
    return Normalizer(mean, variance, wrapper.epsilon, wrapper.clip_obs)
