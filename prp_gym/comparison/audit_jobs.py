"""Jobs of an audit: good and bad policies, beside those that are compared."""

import zlib
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np

from prp_gym.artifacts import to_plain
from prp_gym.baselines import CONTROLLERS
from prp_gym.baselines.degenerate import DEGENERATE
from prp_gym.baselines.floors import FLOORS
from prp_gym.comparison.agents import AgentFile
from prp_gym.comparison.jobs import AgentJob
from prp_gym.errors import PRPError
from prp_gym.evaluation.evaluate import evaluate
from prp_gym.evaluation.rollout import Policy
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.evaluation_job import make_environment
from prp_gym.runs.job import Record, make_record
from prp_gym.tuning import SearchSpace, start_gains

FREQUENCY = 500.0
"""Control frequency of the controllers [Hz]."""

_NEAR, _FAR = 2.0, 5.0  # random factors on the gains lie between their inverse and them
