"""Minari: a dataset of three episodes with everything that `info` says, and its environment made again."""

import os
import tempfile

import gymnasium
from minari import DataCollector, load_dataset

import prp_gym

os.environ["MINARI_DATASETS_PATH"] = tempfile.mkdtemp()

collector = DataCollector(gymnasium.make("PRP-Force-v0", duration=0.2), record_infos=True)
controller = prp_gym.make_baseline("force_inner_position", collector)
for seed in range(3):
    (observation, _), memory, ended = collector.reset(seed=seed), None, False
    while not ended:
        action, memory = controller.predict(observation, memory)
        observation, _, terminated, truncated, _ = collector.step(action)
        ended = terminated or truncated
collector.create_dataset(
    "prp/force-v0",
    algorithm_name="force_inner_position",
    author="prp_gym",
    author_email="none",
    code_permalink="none",
    description="Three episodes of force control.",
    eval_env="PRP-Force-v0",
    ref_min_score=0.0,
    ref_max_score=5.0,
)
dataset = load_dataset("prp/force-v0")
print(dataset.total_steps, dataset[0].infos["contact_force"].shape, dataset.recover_environment())
