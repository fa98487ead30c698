"""The sweep that found the `tuned` gains: `python -m bench.sweep_gains`.

Gains follow from a bandwidth ω and a damping ratio ζ, the same for all joints: K_P = ω², K_D = 2ζω for
inverse dynamics; for PD control both are multiplied by the joint's mean inertia over the joint range.
A candidate's score is the mean over the scenarios `randomized` and `realistic`, on episodes whose seeds no
evaluation uses: gains that look good on the nominal arm alone may chatter with a late torque. Candidates
that do chatter, seen as torques at their limits for more than 5 % of the time, are left out.
"""

import itertools
from functools import cache
from typing import Any

import gymnasium
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

import prp_gym
from prp_gym.robot.arrays import Array

FREQUENCIES = (4.0, 5.6, 8.0, 11.0, 15.0, 20.0, 28.0, 40.0, 56.0, 80.0, 110.0, 160.0)  # rad/s
DAMPING_RATIOS = (0.5, 0.7, 1.0, 1.4, 2.0)
CONTROL_FREQUENCIES = (500.0, 50.0)  # Hz
EPISODES = 12  # in each scenario
SCENARIOS = ("randomized", "realistic")
MOST_SATURATION = 5.0  # % of joints and steps, median over the episodes of a scenario
FIRST_SEED = 1_000_000
LAWS = ("joint_pd", "joint_inverse_dynamics")
_STABLE_UP_TO = 2.0  # 2ζω dt, the double integrator's bound under zero-order hold


@cache
def mean_inertia() -> Array:
    """Diagonal of B, averaged over the joint range (3) [kg m^2, kg, kg m^2]."""
    arm = prp_gym.PRPArm()
    rng = np.random.default_rng(0)
    q = rng.uniform(arm.parameters.joint_lower, arm.parameters.joint_upper, (10_000, 3))
    inertia: Array = np.einsum("nii->ni", arm.inertia_matrix(q)).mean(axis=0)
    return inertia


def gains(law: str, frequency: float, damping_ratio: float) -> dict[str, Array]:
    """Settings of a law for a bandwidth [rad/s] and damping ratio."""
    inertia = mean_inertia() if law == "joint_pd" else np.ones(3)
    return {
        "proportional_gain": inertia * frequency**2,
        "derivative_gain": inertia * 2 * damping_ratio * frequency,
    }


def sweep(law: str, envs: list[gymnasium.Env[Any, Any]]) -> list[tuple[float, float, float]]:
    """Score, bandwidth and damping ratio of every candidate that does not chatter, best first."""
    period = 1.0 / envs[0].get_wrapper_attr("control_frequency")
    grid = [(w, z) for w in FREQUENCIES for z in DAMPING_RATIOS]
    candidates = [(w, z) for w, z in grid if 2.0 * z * w * period < _STABLE_UP_TO]
    results = []
    for frequency, ratio in track(candidates, description=law):
        policy = prp_gym.make_baseline(law, envs[0], "report", **gains(law, frequency, ratio))
        evaluations = [prp_gym.evaluate(policy, env, EPISODES, FIRST_SEED) for env in envs]
        if max(float(e.median["saturation"][0]) for e in evaluations) <= MOST_SATURATION:
            mean = sum(e.score.value for e in evaluations) / len(evaluations)
            results.append((mean, frequency, ratio))
    return sorted(results, reverse=True)


def main() -> None:
    """Sweep the laws at every rate on every environment that they run on, and print the best candidates."""
    console = Console(width=120)
    for rate, environment_id in itertools.product(CONTROL_FREQUENCIES, prp_gym.list_envs()):
        envs = [gymnasium.make(environment_id, scenario=s, control_frequency=rate) for s in SCENARIOS]
        eligible = prp_gym.list_baselines(envs[0].get_wrapper_attr("observation_layout"))
        for law in (name for name in LAWS if name in eligible):
            title = f"{law} on {environment_id} at {rate:g} Hz"
            table = Table(title=title, title_justify="left")
            for header in ("score", "ω [rad/s]", "ζ", "K_P", "K_D"):
                table.add_column(header, justify="right")
            for score, frequency, ratio in sweep(law, envs)[:5]:
                numbers = [np.array2string(v, precision=4) for v in gains(law, frequency, ratio).values()]
                table.add_row(f"{score:.4f}", f"{frequency:g}", f"{ratio:g}", *numbers)
            console.print(table)
        for env in envs:
            env.close()


if __name__ == "__main__":
    main()
