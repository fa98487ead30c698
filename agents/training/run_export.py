"""The best policy of a training run as the files of an agent."""

import json
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import torch

from prp_gym.agents.policy.agent_card import CurvePoint, TrainingRecord
from prp_gym.agents.policy.agent_file import save_agent
from prp_gym.agents.policy.normalizer import Normalizer
from prp_gym.agents.sb3.packages import require
from prp_gym.agents.training.export import AgentFacts, export_agent
from prp_gym.agents.training.model import Learner, make_learner
from prp_gym.agents.training.recipes import Recipe, make_recipe
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.errors import RunFolderError


def write_agent(
    folder: RunFolder, recipe: Recipe, learner: Learner, normalizer: Normalizer, steps: int
) -> None:
    """Write the agent's files into the folder of its run.

    Args:
        folder: folder of the run, with its `run.json` and `curve.json`.
        recipe: recipe of the training.
        learner: model with the agent's weights.
        normalizer: normaliser of the agent's features.
        steps: number of training steps after which the weights were stored.

    Raises:
        InvalidValueError: a network that cannot be exported.
        OutputError: the folder cannot be written to.
    """
    facts = AgentFacts(
        recipe.environment_id,
        recipe.env_kwargs,
        learner.env.get_attr("observation_layout", 0)[0],
        _describe(json.loads(folder.run.read_bytes()), json.loads(folder.curve.read_bytes()), recipe, steps),
    )
    save_agent(export_agent(learner.model, normalizer, facts), folder.agent)


def _describe(run: Mapping[str, Any], curve: Mapping[str, Any], recipe: Recipe, steps: int) -> TrainingRecord:
    points = tuple(CurvePoint(**row) for row in curve["rows"])
    seconds = next(point.seconds for point in points if point.steps == steps)
    return TrainingRecord(run["command"], int(run["seed"]), steps, seconds, recipe.to_plain(), points)


def export_run(path: Path) -> None:
    """Write the agent's files of a finished run that lacks them.

    Args:
        path: path of the run's folder.

    Raises:
        RunFolderError: the folder holds no finished run.
        UnknownNameError: an algorithm, environment or key of the run's `config.yml` that does not exist.
    """
    folder = RunFolder(path.resolve())
    if not folder.is_finished:
        raise RunFolderError(path, "it holds no finished run", "Train it to the end first")
    content = require("yaml").safe_load(folder.config.read_text(encoding="utf-8"))
    algorithm, environment_id = content.pop("algorithm"), content.pop("environment")
    recipe = make_recipe(algorithm, environment_id, content)
    with np.load(path / "best_normalizer.npz", allow_pickle=False) as file:
        normalizer = Normalizer(file["mean"], file["variance"], float(file["epsilon"]), float(file["clip"]))
    with closing(make_learner(recipe, 0)) as learner:
        learner.model.policy.load_state_dict(torch.load(path / "best.pt", weights_only=True))
        write_agent(folder, recipe, learner, normalizer, int(folder.read_result()["best"]["steps"]))
