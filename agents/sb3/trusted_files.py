"""Files of Stable-Baselines3, which can run code when they are opened: for files of trusted authors only."""

import os
import pickle
from pathlib import Path

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecNormalize

from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.errors import AgentFileError
from prp_gym.files.regular_file import open_regular


def open_trusted_model(path: Path, algorithm: type[BaseAlgorithm], name: str) -> BaseAlgorithm:
    """A model as Stable-Baselines3 saved it; code in the file is run.

    Args:
        path: path of the zip file, with or without its suffix.
        algorithm: class of the algorithm that trained the model.
        name: name of the algorithm, for messages.

    Raises:
        AgentFileError: the file is not such a model.
    """
    zipped = Path(f"{path}.zip")
    found = path if os.path.exists(path) or not os.path.exists(zipped) else zipped
    try:
        with open_regular(found, AgentFileError) as file:
            return algorithm.load(file, device="cpu")
    except AgentFileError:
        raise
    except Exception as error:  # unpickling damaged content can raise any exception
        raise AgentFileError(path, f"cannot be read as a model of {name}: {error}") from error


def open_trusted_normalizer(path: Path) -> Normalizer:
    """The normaliser of a VecNormalize as Stable-Baselines3 saved it; code in the file is run.

    Args:
        path: path of the pickle file.

    Raises:
        AgentFileError: the file is not such a wrapper, or its observations are not flat arrays.
    """
    try:
        with open_regular(path, AgentFileError) as file:
            wrapper = pickle.load(file)
    except AgentFileError:
        raise
    except Exception as error:  # unpickling damaged content can raise any exception
        raise AgentFileError(path, f"cannot be read as a VecNormalize: {error}") from error
    if not isinstance(wrapper, VecNormalize) or not wrapper.norm_obs:
        raise AgentFileError(path, "is not a VecNormalize of observations")
    statistics = wrapper.obs_rms
    if not isinstance(statistics, RunningMeanStd):
        raise AgentFileError(path, "is a VecNormalize of observations that are not flat arrays")
    mean, variance = (np.array(values, dtype=np.float64) for values in (statistics.mean, statistics.var))
    return Normalizer(mean, variance, wrapper.epsilon, wrapper.clip_obs)
