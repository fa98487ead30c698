"""Cases of the closed-form models: parameters, kinematics, dynamics, surfaces, trajectories, statistics."""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

from bench.fuzz.strange import STRANGE, VECTORS, mostly, named
from bench.fuzz.target import Prepared, Target
from prp_gym import evaluation
from prp_gym.physics.surface import Surface
from prp_gym.robot import NOMINAL, ArmGeometry, Link, LinkParameters, PRPArm, RobotParameters
from prp_gym.tasks import trajectory
from prp_gym.tasks.target_model import TargetModel

_NUMBER = mostly(st.floats(0.01, 100.0))
_THREE = mostly(st.lists(st.floats(0.01, 100.0), min_size=3, max_size=3))


def _methods(model: Any, names: dict[str, int]) -> list[tuple[Callable[..., object], int]]:
    return [(getattr(model, name), count) for name, count in names.items()]


_ARM = {
    **dict.fromkeys(("forward_kinematics", "reach", "transforms", "analytical_jacobian"), 1),
    **dict.fromkeys(("geometric_jacobian", "euler_rate_map", "inertia_matrix", "gravity_vector"), 1),
    **dict.fromkeys(("potential_energy", "friction_force", "inverse_kinematics_branches"), 1),
    **dict.fromkeys(("analytical_jacobian_derivative", "coriolis_matrix", "bias_force", "kinetic_energy"), 2),
    **dict.fromkeys(("operational_space_dynamics", "inverse_kinematics"), 2),
    **dict.fromkeys(("forward_dynamics", "inverse_dynamics", "regressor"), 4),
    "pose_motion": 3,
    "joint_motion": 3,
    "joint_position_of_pose": 1,
}
_LINK = {
    **dict.fromkeys(("inertia_matrix", "gravity_vector", "friction_force", "potential_energy"), 1),
    **dict.fromkeys(("coriolis_matrix", "bias_force", "kinetic_energy"), 2),
    "forward_dynamics": 3,
    "regressor": 4,
}


def _six(values: Any) -> Any:
    return np.concatenate([values, values]) if isinstance(values, np.ndarray) and values.ndim else values


def _prepare_models(_: Path) -> Prepared:
    methods = [*_methods(PRPArm(), _ARM), *_methods(Link(), _LINK)]

    def call(arguments: tuple[int, tuple[Any, ...], bool]) -> object:
        index, values, wide = arguments
        method, count = methods[index]
        return method(*(_six(value) if wide else value for value in values[:count]))

    which = st.integers(0, len(methods) - 1)
    values = st.tuples(*[st.one_of(VECTORS, VECTORS, STRANGE)] * 4)
    return Prepared(st.tuples(which, values, st.booleans()), call)


def _arm_of(parameters: RobotParameters) -> object:
    arm, q, rate = PRPArm(parameters), np.array([0.3, -0.1, 0.5]), np.array([1.0, 0.2, -1.0])
    return arm.forward_dynamics(q, rate, rate), arm.inverse_dynamics(q, rate, rate), arm.parameter_vector()


def _link_of(parameters: LinkParameters) -> object:
    return Link(parameters).forward_dynamics([1.0], [2.0], [3.0])


def _target_of(keywords: dict[str, Any]) -> object:
    numbers = {"inertia": np.ones(6), "damping": np.ones(6), "stiffness": np.ones(6), "period": 0.002}
    model = TargetModel(**{**numbers, **keywords})
    return model.static_displacement(np.ones(6))


def _prepare_parameters(_: Path) -> Prepared:
    calls: dict[str, tuple[Callable[..., object], list[str]]] = {
        "arm": (lambda k: _arm_of(RobotParameters(**k)), [entry.name for entry in fields(RobotParameters)]),
        "geometry": (
            lambda k: _arm_of(RobotParameters.from_geometry(ArmGeometry(**k))),
            [entry.name for entry in fields(ArmGeometry)],
        ),
        "scaled": (lambda k: _arm_of(NOMINAL.scaled(k["factors"])), ["factors"]),
        "masses": (lambda k: _arm_of(NOMINAL.with_masses(k["masses"])), ["masses"]),
        "density": (lambda k: _arm_of(RobotParameters.from_geometry(ArmGeometry(), **k)), ["density"]),
        "link": (lambda k: _link_of(LinkParameters(**k)), [entry.name for entry in fields(LinkParameters)]),
        "models": (lambda k: (PRPArm(k["model"]), Link(k["model"])), ["model"]),
        "target": (_target_of, ["inertia", "damping", "stiffness", "period"]),
    }
    cases = [
        st.tuples(
            st.just(name),
            named(names, st.one_of(_NUMBER, _THREE, STRANGE)),
        )
        for name, (_, names) in calls.items()
    ]

    def call(arguments: tuple[str, dict[str, Any]]) -> object:
        name, keywords = arguments
        return calls[name][0](keywords)

    return Prepared(st.one_of(cases), call)


def _interquartile_mean(values: Any) -> object:
    """The interquartile mean; nothing for NaN, which is that of NaN."""
    mean = evaluation.interquartile_mean(values)
    return None if np.isnan(np.asarray(values, dtype=np.float64)).any() else mean


def _prepare_surfaces(_: Path) -> Prepared:
    rng = np.random.default_rng(0)
    row = np.linspace(0.1, 1.0, 5)
    runs = {"a": row}
    calls: list[tuple[Callable[..., object], list[Any]]] = [
        (Surface.single, [100.0, (0.0, 0.0, 1.0), 0.1, 1.0]),
        (Surface, [np.ones(1), np.ones(1), np.ones((1, 3)), np.ones(1)]),
        (lambda p: trajectory.Constant(p).sample(np.zeros(1)), [np.zeros((1, 3))]),
        (lambda *a: trajectory.Sine(*a).sample(np.ones(1)), [np.ones((1, 3))] * 4),
        (lambda *a: trajectory.SquareAcceleration(*a).sample(np.ones(1)), [np.ones((1, 3))] * 3),
        (
            lambda *a: trajectory.QuinticWaypoints(*a).sample(np.ones(1)),
            [np.array([[0.0, 1.0]]), np.ones((1, 2, 3))],
        ),
        (_interquartile_mean, [row]),
        (evaluation.bootstrap_interquartile_mean, [row, rng, 0.95, 20]),
        (evaluation.bootstrap_nested, [np.ones((2, 3)), rng, 0.95, 20]),
        (evaluation.bootstrap_crossed, [np.ones((2, 3)), rng, 0.95, 20]),
        (evaluation.bootstrap_difference, [np.ones((2, 3)), np.ones((2, 3)), rng, 0.95, 20]),
        (evaluation.bootstrap_tasks, [{"a": np.ones((2, 3))}, rng, 0.95, 20]),
        (evaluation.probability_of_improvement, [runs, runs, rng, 0.95, 20]),
        (evaluation.paired_probability_of_improvement, [runs, runs, rng, 0.95, 20]),
        (evaluation.performance_profile, [runs, row, rng, 0.95, 20]),
    ]

    def call(arguments: tuple[int, int, Any]) -> object:
        index, slot, value = arguments
        function, values = calls[index]
        values = [value if number == slot % len(values) else old for number, old in enumerate(values)]
        return function(*values)

    return Prepared(st.tuples(st.integers(0, len(calls) - 1), st.integers(0, 4), STRANGE), call)


ROBOT = (
    Target("models", _prepare_models, 2.0),
    Target("parameters", _prepare_parameters, 2.0),
    Target("surfaces", _prepare_surfaces),
)
