"""The laws by name, and how to make one for an environment."""

from typing import Any

from prp_gym.baselines.adaptive import Adaptive
from prp_gym.baselines.admittance import Admittance
from prp_gym.baselines.compliance import Compliance
from prp_gym.baselines.force_inner_position import ForceInnerPosition
from prp_gym.baselines.gains import gain_sets, load_gains
from prp_gym.baselines.impedance import Impedance
from prp_gym.baselines.joint_inverse_dynamics import JointInverseDynamics
from prp_gym.baselines.joint_pd import JointPD
from prp_gym.baselines.operational_inverse_dynamics import OperationalInverseDynamics
from prp_gym.baselines.operational_pd import OperationalPD
from prp_gym.baselines.parallel_force_position import ParallelForcePosition
from prp_gym.baselines.policy import Baseline, ControlInterface
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.tasks.fields import ObservationLayout

TASK_RENDERING = {
    "compliance": ("tuned",),  # at 50 Hz no spring on the angles is stable that is as stiff as its task asks
    "impedance": ("tuned", "tuned_50hz"),
    "admittance": ("tuned", "tuned_50hz"),
}
"""The gain sets with which a law renders what the task asks for, where it asks for anything."""

_CONTROLLERS: tuple[type[Baseline[Any]], ...] = (
    JointPD,
    JointInverseDynamics,
    Adaptive,
    OperationalPD,
    OperationalInverseDynamics,
    Compliance,
    Impedance,
    Admittance,
    ForceInnerPosition,
    ParallelForcePosition,
)

BASELINES: dict[str, type[Baseline[Any]]] = {controller.name: controller for controller in _CONTROLLERS}


def list_baselines(layout: ObservationLayout | None = None) -> list[str]:
    """Names of the laws, or of those that can run on an environment's observations.

    Args:
        layout: `env.unwrapped.observation_layout`; all laws without it.
    """
    if layout is None:
        return list(BASELINES)
    return [name for name, controller in BASELINES.items() if not controller.missing_fields(layout)]


def make_baseline(name: str, env: Any, gains: str = "tuned", **overrides: Any) -> Baseline[Any]:
    """A control law as a policy for an environment.

    Args:
        name: of the law; see `list_baselines`.
        env: an environment of this suite, wrapped or not, or many alike, Gymnasium's or
            Stable-Baselines3's; only their layout, limits and rate are read.
        gains: name of a gain set: `tuned`, `report`, or another that the law has.
        overrides: the law's settings by name, in place of the set's; who gives all of a law's gains is
            free to choose the rate.

    Returns:
        a policy whose `predict` takes observations of the environment.

    Raises:
        UnknownNameError: a law, gain set or setting that does not exist.
        MissingFieldError: the environment does not observe what the law reads.
        InvalidValueError: a setting that is not allowed, gains that are unstable at the environment's
            control frequency, an environment of another suite, or one whose actions are not torques.
    """
    return make_controller(name, ControlInterface.of(env), gains, **overrides)


def make_controller(
    name: str, interface: ControlInterface, gains: str = "tuned", **overrides: Any
) -> Baseline[Any]:
    """A control law on an interface; see `make_baseline`."""
    if name not in BASELINES:
        raise UnknownNameError("baseline", name, BASELINES)
    controller = BASELINES[name]
    values = load_gains(name, gains, interface.environment_id)
    values.pop("source")
    least = values.pop("minimum_frequency", 0.0)
    if gains in TASK_RENDERING.get(name, ()):
        values |= {
            key: interface.target_impedance[key]
            for key in controller.rendered
            if key in interface.target_impedance
        }
    own_gains = set(controller.settings_class.vectors) <= set(overrides)
    if round(1.0 / interface.period, 6) < least and not own_gains:
        allowed = f"at least {least:g} with gains {gains!r} of law {name!r}, which are unstable below it"
        others = ", ".join(item for item in gain_sets(name) if item != gains)
        raise InvalidValueError(
            "control_frequency", round(1.0 / interface.period, 6), f"{allowed} (other sets: {others})", "Hz"
        )
    return controller(interface, controller.settings_class.from_mapping(name, {**values, **overrides}))
