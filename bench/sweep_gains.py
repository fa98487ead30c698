"""The sweep that found the `tuned` gains: `python -m bench.sweep_gains [CONTROLLER ...]`.

Gains are computed from a bandwidth ω and a damping ratio ζ, equal for all joints or axes, by `CANDIDATES`.
A candidate's score is the mean over the episodes of the scenarios `randomized` and `realistic`, with seeds
that no evaluation uses: gains that look good on the nominal arm alone may chatter with an actuation delay,
and a median would hide the episodes in which the controller does not reach the goal. Candidates that
chatter, detected as torques at their limits for more than 5 % of the time, are left out. Impedance, and the
compliant frame of admittance, have no gains to sweep: their tasks specify the target impedance.
"""

import itertools
import sys
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import gymnasium
import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table

import prp_gym
from prp_gym.baselines import BASELINES
from prp_gym.baselines.base.gains import load_gains
from prp_gym.errors import PRPError, UnknownNameError
from prp_gym.robot.arrays import Array

FREQUENCIES = (4.0, 8.0, 11.0, 15.0, 20.0, 28.0, 40.0, 56.0, 80.0, 110.0, 160.0)  # rad/s
DAMPING_RATIOS = (0.5, 0.7, 1.0, 1.4, 2.0, 4.0, 8.0)
EPISODES = 12  # in each scenario
SCENARIOS = ("randomized", "realistic")
MOST_SATURATION = 5.0  # % of joints and steps, median over the episodes of a scenario
FIRST_SEED = 1_000_000
_STABLE_UP_TO = 2.0  # 2ζω dt, the double integrator's bound under zero-order hold

JOINT_TASKS = ("JointRegulation", "JointTracking", "Adaptive")
POSE_TASKS = ("PoseRegulation", "PoseTracking")
TASKS: dict[str, tuple[str, ...]] = {
    "joint_pd": JOINT_TASKS,
    "joint_inverse_dynamics": JOINT_TASKS,
    "adaptive": JOINT_TASKS,
    "operational_pd": POSE_TASKS,
    "operational_inverse_dynamics": POSE_TASKS,
    "compliance": ("Compliance",),
    "admittance": ("Admittance",),
    "force_inner_position": ("Force",),
    "parallel_force_position": ("ForcePosition",),
}
CONTACT_CONTROLLERS = ("compliance", "admittance", "force_inner_position", "parallel_force_position")
RATES = dict.fromkeys(CONTACT_CONTROLLERS, (500.0,))  # Hz; the others also at 50 Hz

LINK_INERTIA = np.array([0.5])
POSE_INERTIA = np.array([0.7, 0.7, 0.14, 0.15, 0.008, 0.008])
"""Inertias of the pose's axes, which J_Aᵀ maps approximately to B's diagonal."""


@cache
def mean_inertia() -> Array:
    """Diagonal of B, averaged over the joint range (3) [kg m^2, kg, kg m^2]."""
    arm = prp_gym.PRPArm()
    rng = np.random.default_rng(0)
    q = rng.uniform(arm.parameters.joint_lower, arm.parameters.joint_upper, (10_000, 3))
    inertia: Array = np.einsum("nii->ni", arm.inertia_matrix(q)).mean(axis=0)
    return inertia


COMPLIANCE_INERTIA = np.array([1.0, 1.0, 1.0, 0.53, 0.08, 0.08])
"""Shares of the pose's axes in the damping of compliance control, found on a coarse grid."""

Gains = Mapping[str, Array | float]
Candidate = Callable[[float, float, Array], Gains]


def scaled(frequency: float, ratio: float, inertia: Array) -> Gains:
    """K_P = ω² times the inertia, K_D = 2ζω times the inertia."""
    return {
        "proportional_gain": inertia * frequency**2,
        "derivative_gain": inertia * 2 * ratio * frequency,
    }


def unscaled(frequency: float, ratio: float, inertia: Array) -> Gains:
    """K_P = ω², K_D = 2ζω: the controller itself multiplies by the inertia."""
    return scaled(frequency, ratio, np.ones(1))


def sliding(frequency: float, ratio: float, inertia: Array) -> Gains:
    """Λ = ω, K_D = ζω times the inertia."""
    return {"reference_gain": np.array([frequency]), "damping_gain": inertia * ratio * frequency}


def damped(frequency: float, ratio: float, inertia: Array) -> Gains:
    """The damping alone, 2ζω times the inertia; the task specifies the stiffness."""
    return {"damping": inertia * 2 * ratio * frequency}


def pressing(frequency: float, ratio: float, inertia: Array) -> Gains:
    """K_P = ω² and K_D = 2ζω of the inner position loop, M_d = 1; ω/12 for the force loop around it.

    The design of the force loop neglects the dynamics of the position loop. At a bandwidth twelve times
    lower, the phase lag of the inner loop is at most atan(2ζ/12), 10° at ζ = 1, which keeps the damping.
    """
    return {**unscaled(frequency, ratio, inertia), "bandwidth": frequency / 12.0}


CANDIDATES: dict[str, Candidate] = {
    "joint_pd": scaled,
    "joint_inverse_dynamics": unscaled,
    "adaptive": sliding,
    "operational_pd": scaled,
    "operational_inverse_dynamics": unscaled,
    "compliance": damped,
    "admittance": unscaled,
    "force_inner_position": pressing,
    "parallel_force_position": pressing,
}


def inertia_of(controller: str, task: str) -> Array:
    """Inertia that scales a controller's gains on an environment."""
    if task == "Adaptive":
        return LINK_INERTIA
    if controller == "compliance":
        return COMPLIANCE_INERTIA
    return (
        POSE_INERTIA
        if "end_effector_pose" in BASELINES[controller].policy.measured_fields
        else mean_inertia()
    )


def sweep(controller: str, task: str, rate: float) -> list[tuple[float, float, float]]:
    """Score, bandwidth and damping ratio of every candidate that does not chatter, best first."""
    environment_id = f"PRP-{task}-v0"
    envs = [gymnasium.make(environment_id, scenario=s, control_frequency=rate) for s in SCENARIOS]
    inertia = inertia_of(controller, task)
    base = (
        "tuned"
        if rate >= load_gains(controller, "tuned", environment_id)["minimum_frequency"]
        else "tuned_50hz"
    )
    grid = [(w, z) for w in FREQUENCIES for z in DAMPING_RATIOS if 2.0 * z * w / rate < _STABLE_UP_TO]
    results = []
    for frequency, ratio in track(grid, description=f"{controller} {task} {rate:g} Hz", transient=True):
        settings: dict[str, Any] = dict(CANDIDATES[controller](frequency, ratio, inertia))
        policy = prp_gym.make_baseline(controller, envs[0], base, **settings)
        evaluations = [prp_gym.evaluate(policy, env, EPISODES, FIRST_SEED) for env in envs]
        if max(float(e.median["saturation"][0]) for e in evaluations) <= MOST_SATURATION:
            mean = np.mean([evaluation.metrics["score"] for evaluation in evaluations])
            results.append((float(mean), frequency, ratio))
    for env in envs:
        env.close()
    return sorted(results, reverse=True)


def main(controllers: list[str]) -> None:
    """Sweep controllers at every frequency on the tasks that they are tuned for; print the best candidates.

    Raises:
        UnknownNameError: A controller has no gains to sweep; nothing is swept then.
    """
    for controller in controllers:
        if controller not in TASKS:
            raise UnknownNameError("controller to sweep", controller, TASKS)
    console = Console(width=120)
    for controller in controllers or list(TASKS):
        for task, rate in itertools.product(TASKS[controller], RATES.get(controller, (500.0, 50.0))):
            table = Table(title=f"{controller} on PRP-{task}-v0 at {rate:g} Hz", title_justify="left")
            for header in ("score", "ω [rad/s]", "ζ", "gains"):
                table.add_column(header, justify="right")
            for score, frequency, ratio in sweep(controller, task, rate)[:5]:
                gains = CANDIDATES[controller](frequency, ratio, inertia_of(controller, task))
                numbers = ", ".join(
                    f"{n} {np.array2string(np.asarray(v), precision=4)}" for n, v in gains.items()
                )
                table.add_row(f"{score:.4f}", f"{frequency:g}", f"{ratio:g}", numbers)
            console.print(table)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except PRPError as error:
        sys.exit(f"error: {error}")
