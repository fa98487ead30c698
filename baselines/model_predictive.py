"""Model-predictive control of the joints: one iteration of iterative LQR in each control period."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.base.policy import Baseline, ControllerState, Observed
from prp_gym.baselines.base.references import JointReference
from prp_gym.baselines.base.settings import Settings, Vector
from prp_gym.baselines.base.spec import ControllerData, ControllerSpec, register_controller
from prp_gym.baselines.predictive.formulas import KNOTS
from prp_gym.baselines.predictive.grid import interval_durations, shifted
from prp_gym.baselines.predictive.iteration import Problem, improve
from prp_gym.robot.arrays import Array, apply
from prp_gym.robot.link import Link
from prp_gym.symbolic.array import is_symbolic, untraceable

ITERATIONS = 2
"""Number of iterations in a control period."""

LIMITED = 1.0 - 1e-9
"""Share of an actuator's limit from which it counts as reached."""

STOP_FACTOR = 10.0
"""Weight of a position beyond a joint stop, in multiples of that of a position error."""


@dataclass(frozen=True, eq=False)
class ModelPredictiveSettings(Settings):
    """Settings of `ModelPredictiveController`.

    Attributes:
        position_weight: Q_P (joints), above 0 [1/rad², 1/m², 1/rad²].
        velocity_weight: Q_V (joints) [(s/rad)², (s/m)², (s/rad)²].
        error_scale: δ (joints), position error about which its cost turns from quadratic to linear, above 0
            [rad, m, rad].
        observer_gain: λ (joints), rate at which the disturbance torque is estimated [1/s].
        planned_share: α (joints), share of the actuator limits within which all torques but the one that is
            applied are planned, above 0; what it lacks to 1 is the margin for the model's errors [1].
        horizon: T, duration of the plan, at least 16 control periods [s].
    """

    position_weight: Any
    velocity_weight: Any
    error_scale: Any
    observer_gain: Any = 0.0
    planned_share: Any = 1.0
    horizon: Any = 0.3

    vectors: ClassVar = {
        "position_weight": Vector("joint", "1/rad², 1/m², 1/rad²", above_zero=True),
        "velocity_weight": Vector("joint", "s²/rad², s²/m², s²/rad²"),
        "error_scale": Vector("joint", "rad, m, rad", above_zero=True),
        "observer_gain": Vector("joint", "1/s"),
        "planned_share": Vector("joint", "1", above_zero=True),
    }
    numbers: ClassVar = {"horizon": "s"}


class ModelPredictiveController(Baseline[ModelPredictiveSettings]):
    """τ = τ_0 - d̂, with the first torque of a plan τ_0 ... τ_15 that minimises a cost over the horizon T.

    The plan starts from the measured state and obeys B(q) q̈ + n(q, q̇) = τ_k over intervals h_k that are as
    long as the control period at first and grow geometrically to T. It minimises V_T + Σ_k h_k (ρ + ½ |τ_k -
    τ_d|²/τ_max²), a sum over the joints, with ρ = κ(√(1 + 2V/κ) - 1), κ = Q_P δ², V = ½ Q_P q̃² + ½ Q_V q̃˙²: V
    near the goal, and in proportion to the errors beyond δ. τ_d is the inverse dynamics of the desired
    motion, which is extrapolated with constant acceleration; V_T is the cost after T of a double integrator
    with the inertia B_ii, in closed form. Positions beyond a joint stop cost as errors do, ten times as much.
    The torque that is applied stays within the actuator limits, the later ones within their share α.

    Each period the last plan is shifted and improved by two iterations of iterative LQR: exact derivatives
    of the model, a Riccati recursion whose torques are minimised within their limits, a forward pass that
    follows them, and a search along it, which takes no step that increases the cost. Where limits become
    active along a step, the iteration may keep the plan as it is. A plan along which the model diverges, as
    from speeds that the actuators cannot brake, is given up for τ_d. The disturbance torque d̂ = d̂ + λ B (q̇ -
    q̇_expected) is what the model lacks; it is held while a limit is active.

    Near a constant goal, with the exact model and no limit active, the loop is that of the linear-quadratic
    regulator of the sampled arm. With r = B²/τ_max² each joint has about the poles of s² + 2ζω s + ω²,
    ω⁴ = Q_P/r and 2ζω = √((Q_V + 2√(Q_P r))/r), stable for all Q_P > 0 and Q_V ≥ 0. The error of d̂ has the
    factor 1 - λ dt from one period to the next: the loop is stable for 0 < λ dt < 2 and unstable above, see
    docs/theory.md. It is not traced into compiled episodes: its iterations are compiled by themselves where
    there is a compiler, and run in NumPy, with the same bits, where there is none.

    Source: Li 2004; Tassa 2014; Diehl 2005 for few iterations per period; Huber 1981 for ρ.
    """

    measured_fields = ("joint_position", "joint_velocity")
    settings_class = ModelPredictiveSettings
    compiled = False
    slow_without_compiler: ClassVar[bool] = True

    def __init__(self, interface: ControlInterface, settings: ModelPredictiveSettings) -> None:
        super().__init__(interface, settings)
        self._duration = interval_durations(interface.period, self.settings.horizon)
        self._end = np.cumsum(self._duration, axis=0)

    def initial_state(self, observed: Observed) -> ControllerState:
        """Plan less τ_d, disturbance torque and expected velocity (..., size): zero, zero, and as it is."""
        velocity = observed["joint_velocity"]
        lead, joints = velocity.shape[:-1], velocity.shape[-1]
        return np.zeros((*lead, KNOTS * joints)), np.zeros((*lead, joints)), velocity.copy()

    def control(self, observed: Observed, state: ControllerState) -> tuple[Array, ControllerState]:
        """See the class."""
        if is_symbolic(observed["joint_position"]):
            raise untraceable("the optimisation of a plan")
        lead, joints = observed["joint_position"].shape[:-1], observed["joint_position"].shape[-1]
        rows = {name: values.reshape(-1, values.shape[-1]) for name, values in observed.items()}
        plan, before, expected = (part.reshape(-1, part.shape[-1]) for part in state)
        disturbance = self._estimated(rows, before, expected)
        problem = self._problem(rows, disturbance)
        relative = shifted(plan.reshape(-1, KNOTS, joints), self._duration)
        found = improve(self.model, problem, relative + problem.effort)
        for _ in range(ITERATIONS - 1):
            found = improve(self.model, problem, found.torque)
        torque = found.torque[:, 0] - disturbance
        is_limited = np.abs(torque) >= LIMITED * self.interface.torque_limit
        kept = np.where(is_limited.any(axis=-1, keepdims=True), before, disturbance)
        planned = (found.torque - problem.effort).reshape(len(kept), -1)
        follows = np.isfinite(planned).all(axis=-1, keepdims=True)
        after = np.where(follows, planned, 0.0), kept, found.expected[:, joints:]
        return torque.reshape(*lead, joints), tuple(part.reshape(*lead, part.shape[-1]) for part in after)

    def _estimated(self, observed: Observed, disturbance: Array, expected: Array) -> Array:
        """The disturbance torque (M, joints), within the actuator limits."""
        B, limit = self.model.inertia_matrix(observed["joint_position"]), self.interface.torque_limit
        missing = apply(B, observed["joint_velocity"] - expected)
        estimate = disturbance + self.settings.observer_gain * missing
        within: Array = np.minimum(np.maximum(estimate, -limit), limit)
        return within

    def _problem(self, observed: Observed, disturbance: Array) -> Problem:
        """The problem of each plan, in torques τ + d̂."""
        reference, limit = self.references.joint(observed), self.interface.torque_limit
        ends, middles = (_extrapolated(reference, self._end - share * self._duration) for share in (0.0, 0.5))
        desired = np.concatenate([ends.position, ends.velocity], axis=-1)
        B = self.model.inertia_matrix(middles.position)
        effort = apply(B, middles.acceleration) + self.model.bias_force(middles.position, middles.velocity)
        share = np.ones((KNOTS, 1)) * self.settings.planned_share
        share[0] = 1.0
        state = np.concatenate([observed["joint_position"], observed["joint_velocity"]], axis=-1)
        weight = self._weight(B[:, -1])
        return Problem(
            state=state,
            duration=self._duration,
            desired=desired,
            weight=weight,
            threshold=weight[..., : len(limit)] * self.settings.error_scale**2,
            effort=effort,
            effort_weight=self._duration / self._rated**2,
            stops=np.repeat(self._stops[None], KNOTS, axis=0),
            stop_weight=self._duration * STOP_FACTOR * self.settings.position_weight,
            low=disturbance[:, None] - share * limit,
            high=disturbance[:, None] + share * limit,
        )

    @property
    def _stops(self) -> Array:
        """Least and greatest joint positions (2 joints) [rad, m, rad]; the link has none."""
        if isinstance(self.model, Link):
            return np.array([-np.inf, np.inf])
        return np.concatenate(self.model.joint_limits)

    @property
    def _rated(self) -> Array:
        """The nominal actuator limits (joints), in whose shares torques are weighed [N m, N, N m]."""
        return np.array(self.model.parameters.torque_limit)

    def _weight(self, inertia: Array) -> Array:
        """Weights (M, N, 3 joints) of the errors, the last ones with the cost after the horizon."""
        p, s = self.settings.position_weight, self.settings.velocity_weight
        stage = np.concatenate([p, 0.0 * p, s])
        weight = np.repeat((self._duration * stage)[None], len(inertia), axis=0)
        r = (np.diagonal(inertia, axis1=-2, axis2=-1) / self._rated) ** 2
        mixed = np.sqrt(p * r)
        rate = np.sqrt(s + 2.0 * mixed)
        weight[:, -1] += np.concatenate([np.sqrt(p) * rate, mixed, np.sqrt(r) * rate], axis=-1)
        return weight


def _extrapolated(reference: JointReference, time: Array) -> JointReference:
    """The motion (M, N, joints) at times (N, 1) from now, with constant acceleration."""
    position, velocity, acceleration = (part[:, None] for part in reference)
    later = position + time * (velocity + 0.5 * time * acceleration)
    return JointReference(later, velocity + time * acceleration, acceleration + 0.0 * time)


register_controller(
    ControllerSpec(
        name="model_predictive",
        summary="model-predictive control: one iteration of iterative LQR with torque limits in each period",
        policy=ModelPredictiveController,
        data=ControllerData.beside(__file__),
        command_inputs=("joint_offset",),
    )
)
