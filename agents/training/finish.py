"""The end of a training run: files of the best policy and of the result."""

import io
from typing import Any

import numpy as np
import torch

from prp_gym.agents.training.model import Learner
from prp_gym.agents.training.recipes import Recipe
from prp_gym.agents.training.run_export import write_agent
from prp_gym.agents.training.run_folder import RunFolder
from prp_gym.agents.training.training_state import TrainingState
from prp_gym.artifacts import write_file, write_json
from prp_gym.files.checksum import seal


def finish_run(
    recipe: Recipe, seed: int, folder: RunFolder, learner: Learner, state: TrainingState
) -> dict[str, Any]:
    """Write the best policy and, as the last file, the result.

    Args:
        recipe: recipe of the training.
        seed: training seed.
        folder: folder of the run.
        learner: model at the end of training; it is given the weights of the best policy.
        state: progress of the run at its end.

    Returns:
        the content of `result.json`.

    Raises:
        InvalidValueError: a network that cannot be exported.
        OutputError: the folder cannot be written to.
    """
    best = state.best[0]
    weights = io.BytesIO()
    torch.save(dict(best.weights), weights)
    write_file(folder.path / "best.pt", weights.getvalue())
    scale = io.BytesIO()
    normalizer = best.normalizer
    np.savez(
        scale,
        mean=normalizer.mean,
        variance=normalizer.variance,
        epsilon=normalizer.epsilon,
        clip=normalizer.clip,
    )
    write_file(folder.path / "best_normalizer.npz", scale.getvalue())
    learner.model.policy.load_state_dict(dict(best.weights))
    write_agent(folder, recipe, learner, normalizer, best.steps)
    result = {
        "environment": recipe.environment_id,
        "algorithm": recipe.algorithm,
        "action_mode": recipe.action_mode,
        "seed": seed,
        "steps": learner.model.num_timesteps,
        "seconds": state.seconds,
        "evaluation_seconds": state.evaluation_seconds,
        "resumes": state.resumes,
        "best": {"steps": best.steps, "score": best.score},
        "last_score": state.curve[-1].score,
        "violations": state.curve[-1].violations,
    }
    write_json(folder.result, seal(result))
    folder.progress.unlink(missing_ok=True)
    return result
