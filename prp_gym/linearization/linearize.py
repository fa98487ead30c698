"""`linearize`: the linear model of an environment around its present state, and of its closed loop."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from prp_gym.checks import as_numbers
from prp_gym.envs.action_mode import TORQUE
from prp_gym.envs.core.argument_checks import clip_actions
from prp_gym.errors import InvalidValueError, ShapeError
from prp_gym.evaluation.policy_state import PolicyState
from prp_gym.evaluation.rollout import check_environment
from prp_gym.linearization.controller_jacobian import ControllerJacobian
from prp_gym.linearization.result import Linearization
from prp_gym.physics.engines import in_closed_form
from prp_gym.physics.sampled_plant import SampledPlant
from prp_gym.robot.arrays import Array

_FORCE = "contact_force"


def linearize(
    env: Any, controller: Any = None, action: Any = None, state: PolicyState = None
) -> Linearization:
    """The exact linear model of an environment around its present state, over one control period.

    The derivatives are those of the simulated step, through joint stops, friction and contact; where a
    constraint is about to change its zone, they are those of its present one. They are computed from the
    closed form of the step, whichever engine simulates the environment, which is left as it is.

    The torques of the period are those of the action, clipped to the actuator limits; or of the controller,
    with the delay of the actuators and without their noise; or else those that have acted up to now.

    Args:
        env: an environment of this suite, wrapped or not, in action mode `torque`, whose episode has begun.
        controller: a controller made for it, see `prp_gym.make_baseline`; None for the robot alone.
        action: action (joints) of the period; None with a controller, whose action it is.
        state: state of the controller, as its last `predict` returned it; None at the start of an episode.

    Returns:
        the linear model, with the closed loop if there is a controller.

    Raises:
        InvalidValueError: an environment of another suite, many environments, another action mode; a world
            that the closed form lacks; a controller with a `predict` of its own, or made for other
            observations; an action beside a controller, a state without one; a torque with which the
            simulation leaves its bounds.
        EpisodeError: an environment that was never reset, or has diverged.
        ShapeError: an action or a state of another shape.
        NonFiniteError: NaN or infinity in the action or the state.
        UntraceableError: a controller that uses more than arithmetic on arrays, or keeps anything but its
            state.
        CompilerError: this machine has neither the compiled code nor a compiler.
    """
    inner = _checked(env)
    loop = inner.loop
    plant = SampledPlant(in_closed_form(loop.physics), loop.config.substeps)
    if controller is None:
        if state is not None:
            raise InvalidValueError("state", state, "None without a controller")
        return _of_plant(inner, plant, plant.torque if action is None else _torque(loop, action))
    if action is not None:
        raise InvalidValueError("action", action, "None with a controller, whose action it is")
    _check_controller(controller, inner)
    jacobian = ControllerJacobian(controller, loop.present_parts(), loop.observation[0])
    return _closed_loop(inner, plant, jacobian, jacobian.state_row(state))


def _checked(env: Any) -> Any:
    """The environment without its wrappers, which can be linearised."""
    if not hasattr(env, "unwrapped"):
        raise InvalidValueError("env", env, "an environment of prp_gym, wrapped or not")
    inner: Any = check_environment(env)
    if not hasattr(inner, "loop") or inner.loop.num_envs != 1 or not hasattr(inner, "require_started"):
        raise InvalidValueError("env", env, "a single environment, not one of many")
    if inner.action_mode != TORQUE:
        raise InvalidValueError("action_mode", inner.action_mode, f"{TORQUE!r}")
    inner.require_started("linearize")
    inner.loop.require_ready(np.zeros(1, dtype=np.bool_))
    return inner


def _check_controller(controller: Any, inner: Any) -> None:
    """Refuse a controller whose formula is not that of `act`, or that was made for another environment."""
    if not getattr(type(controller), "compiled", False) or "predict" in getattr(controller, "__dict__", {}):
        allowed = "a controller whose predict is that of Baseline"
        raise InvalidValueError("controller", controller, allowed)
    interface = controller.interface
    if (
        interface.layout != inner.observation_layout
        or interface.torque_limit.shape != inner.torque_limit.shape
    ):
        environment = inner.task.environment_id
        raise InvalidValueError("controller", controller, f"one made for {environment} with these keywords")


def _torque(loop: Any, action: Any) -> Array:
    """The torques (n) that an action commands."""
    values = as_numbers("action", action)
    if values.shape != (loop.joints,):
        raise ShapeError("action", values.shape, f"({loop.joints},)")
    torque: Array = clip_actions(values[None])[0] * loop.torque_limit
    return torque


def _of_plant(inner: Any, plant: SampledPlant, torque: Array) -> Linearization:
    """The linear model of the robot alone."""
    after, A, B = plant.period(torque)
    C, D = plant.measurement()
    fields, size = inner.task.measured_fields, len(plant.state)
    names = tuple(f"{field.name}[{index}]" for field in fields for index in range(len(field.units)))
    units = tuple(unit for field in fields for unit in field.units)
    period = 1.0 / inner.control_frequency
    model = Linearization(A, B, C, D, plant.state, torque, after, names[:size], units[:size], period)
    return replace(model, measured_names=names, measured_units=units)


def _closed_loop(inner: Any, plant: SampledPlant, jacobian: ControllerJacobian, row: Array) -> Linearization:
    """The linear model of the robot and of its loop with a controller, in a state (size)."""
    found, delayed = jacobian.at(row), jacobian.delayed
    joints, memory = len(plant.torque), len(jacobian.memory)
    torque, kept, after = np.split(found.results, [joints, joints + memory])
    model = _of_plant(inner, plant, torque)
    held = joints if jacobian.reads[_columns_of_force(inner)].any() else 0
    by_measurement = found.by_observation[:, : len(model.C)]
    parts = (by_measurement @ model.C, by_measurement @ model.D[:, :held])
    results = np.concatenate([*parts, found.by_memory[:, delayed], found.by_state], axis=1)
    moved = model.B @ results[:joints]
    moved[:, : len(plant.state)] += model.A
    rest = results[np.concatenate([joints + delayed, np.arange(joints + memory, len(results))])]
    names, units = _components_of_loop(inner, held, delayed, len(row))
    return replace(
        model,
        A_cl=np.concatenate([moved, results[:held], rest]),
        closed_loop_state=np.concatenate([plant.state, plant.torque[:held], jacobian.memory[delayed], row]),
        next_closed_loop_state=np.concatenate([model.next_state, torque[:held], kept[delayed], after]),
        closed_loop_names=(*model.names, *names),
        closed_loop_units=(*model.units, *units),
    )


def _columns_of_force(inner: Any) -> slice:
    """The columns of the contact force in an observation: those that depend on the torques."""
    columns: slice = inner.observation_layout.slices.get(_FORCE, slice(0, 0))
    return columns


def _components_of_loop(
    inner: Any, held: int, delayed: NDArray[np.intp], states: int
) -> tuple[list[str], list[str]]:
    """Names and units of the closed loop's state behind that of the robot."""
    units = inner.action_fields[0].units
    ages, joints = np.divmod(delayed, len(units))
    names = [f"applied_torque[{joint}]" for joint in range(held)]
    names += [f"commanded_torque_{age + 1}_ago[{joint}]" for age, joint in zip(ages, joints, strict=True)]
    names += [f"controller_state[{index}]" for index in range(states)]
    return names, [*units[:held], *(units[joint] for joint in joints), *[""] * states]
