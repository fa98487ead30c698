"""`Linearization`: the linear model of an environment around its present state."""

from dataclasses import dataclass

from prp_gym.robot.arrays import Array


@dataclass(frozen=True, eq=False)
class Linearization:
    """The linear model of one control period: x' ≈ next_state + A (x - state) + B (τ - torque).

    The state x holds joint position and velocity of n joints; τ are the joint torques that act during the
    period. The measurement before the period is y ≈ y_0 + C (x - state) + D (τ_0 - its present value), with
    the torques τ_0 that have acted up to now, on which a contact force depends.

    With a controller, z' ≈ next_closed_loop_state + A_cl (z - closed_loop_state) is the model of the closed
    loop, whose state z holds x, then the torques τ_0 if the controller reads a contact force, then commands
    that the actuators have yet to apply, then the state of the controller.

    Attributes:
        A: derivatives (2n, 2n) of the state after the period by the state before it.
        B: derivatives (2n, n) of the state after the period by the torques during it.
        C: derivatives (m, 2n) of the measurement now by the state.
        D: derivatives (m, n) of the measurement now by the torques that have acted up to now.
        state: state x (2n) around which the model holds.
        torque: torques τ (n) around which it holds [N m, or N for a prismatic joint].
        next_state: state (2n) a period later.
        names: names (2n) of the components of x.
        units: their units (2n).
        period: control period [s].
        measured_names: names (m) of the components of y.
        measured_units: their units (m).
        A_cl: derivatives (k, k) of z a period later by z; None without a controller.
        closed_loop_state: z (k); None without a controller.
        next_closed_loop_state: z (k) a period later; None without a controller.
        closed_loop_names: names (k) of the components of z; empty without a controller.
        closed_loop_units: their units (k), empty texts for the controller's own.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    state: Array
    torque: Array
    next_state: Array
    names: tuple[str, ...]
    units: tuple[str, ...]
    period: float
    measured_names: tuple[str, ...] = ()
    measured_units: tuple[str, ...] = ()
    A_cl: Array | None = None
    closed_loop_state: Array | None = None
    next_closed_loop_state: Array | None = None
    closed_loop_names: tuple[str, ...] = ()
    closed_loop_units: tuple[str, ...] = ()
