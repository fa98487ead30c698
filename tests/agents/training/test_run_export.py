"""The agent that a training run leaves behind."""

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from prp_gym.agents.algorithms import ALGORITHMS
from prp_gym.agents.policy.agent_file import load_agent
from prp_gym.agents.sb3.make_vec_env import make_sb3_vec_env
from prp_gym.agents.training.recipes import FIRST_HELD_OUT_SEED
from prp_gym.agents.training.run_export import export_run
from prp_gym.agents.training.train import train
from prp_gym.errors import RunFolderError
from tests.support.training_runs import ID, tiny_job


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_agent_of_a_run_scores_on_held_out_episodes_as_its_training_says(
    tmp_path: Path, algorithm: str
) -> None:
    job = tiny_job(tmp_path / "run", algorithm)
    result = train(job)
    agent = load_agent(job.folder / "agent")
    returns, done = np.zeros(4), np.zeros(4, dtype=np.bool_)
    with closing(
        make_sb3_vec_env(ID, 4, seed=FIRST_HELD_OUT_SEED, num_threads=1, **job.recipe.env_kwargs)
    ) as env:
        observation, horizon = np.asarray(env.reset()), env.get_attr("config", 0)[0].horizon
        state, begins = None, np.ones(4, dtype=np.bool_)
        while not done.any():
            action, state = agent.predict(observation, state=state, episode_start=begins)
            observation, reward, done, _ = env.step(action)  # type: ignore[assignment]
            returns, begins = returns + reward, done
    # float32 actions of numpy and torch differ in their last bits
    assert returns.mean() / horizon == pytest.approx(result["best"]["score"], abs=1e-4)
    assert agent.card.run.steps == result["best"]["steps"]
    assert len(agent.card.run.curve) > 2


def test_finished_run_without_its_agent_is_exported_later(tmp_path: Path) -> None:
    job = tiny_job(tmp_path / "run")
    with pytest.raises(RunFolderError, match="no finished run"):
        export_run(job.folder)
    train(job)
    files = [job.folder / name for name in ("agent.safetensors", "agent.json")]
    before = [path.read_bytes() for path in files]
    for path in files:
        path.unlink()
    export_run(job.folder)
    assert [path.read_bytes() for path in files] == before
