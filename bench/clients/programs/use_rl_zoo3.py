"""rl-baselines3-zoo: train, enjoy and optimise through its programs, with the suite's recipes."""

import subprocess
import sys


def run(*arguments: str) -> None:
    """Run a module with this interpreter, and stop if it fails."""
    print("python -m", *arguments, flush=True)
    subprocess.run([sys.executable, "-m", *arguments], check=True)


ENV = ["--algo", "ppo", "--env", "PRP-Force-v0", "--gym-packages", "prp_gym", "-f", "logs"]
TRAIN = [*ENV, "--conf-file", "ppo.yml", "--env-kwargs", "duration:0.1"]  # short episodes, for a quick check

run("prp_gym.cli.main", "zoo", "ppo.yml")  # or: prp-gym zoo ppo.yml
run(
    "rl_zoo3.train",
    *TRAIN,
    "--n-timesteps",
    "400",
    "--hyperparams",
    "n_envs:2",
    "n_steps:100",
    "batch_size:50",
)
run("rl_zoo3.enjoy", *ENV, "--n-timesteps", "100", "--no-render")
TRIALS = ["-optimize", "--n-trials", "2", "--n-startup-trials", "1", "--n-evaluations", "1"]
run(
    "rl_zoo3.train",
    *TRAIN,
    "--n-timesteps",
    "200",
    *TRIALS,
    "--eval-episodes",
    "1",
    "--hyperparams",
    "n_envs:1",
)
