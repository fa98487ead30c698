"""The runs of the experiments, by the names that their files give them, with all their numbers."""

import math
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from tests.reproduction.independent import contact, free_space
from tests.reproduction.independent.arm import Array, ReportArm
from tests.reproduction.independent.contact import Pursuit, SteadyPursuit
from tests.reproduction.independent.estimated import EstimatedPursuit, FittedSurface, Speeds
from tests.reproduction.independent.free_space import PERIOD
from tests.reproduction.independent.references import (
    GOAL,
    HOME,
    TIMES,
    WAYPOINTS,
    Path,
    constant,
    pose_path,
    pose_quintic,
    quintic,
    sine,
    square,
)
from tests.reproduction.independent.simulation import Adaptation, Signals, Wall, simulate_arm, simulate_link

ARM = ReportArm()
WRONG = ReportArm((0.9, 0.5, 0.7))

STEP_PATH = quintic(TIMES, WAYPOINTS)
HOME_PATH = quintic((0.0, *TIMES), (HOME, *WAYPOINTS))
SLANTED = np.array([-0.3, -0.9, 0.3]) / math.sqrt(0.99)


def _six(*values: float) -> Array:
    return np.array(values if len(values) == 6 else values * 6)


def _pd(reference: Path, K_P: Array, K_D: Array, duration: float, gravity: str = "current") -> Signals:
    return simulate_arm(free_space.joint_pd(reference, ARM, K_P, K_D, gravity), reference, duration)


def _computed(reference: Path, K_P: float, K_D: float, duration: float, model: ReportArm = ARM) -> Signals:
    controller = free_space.joint_inverse_dynamics(reference, model, K_P, K_D)
    return simulate_arm(controller, reference, duration)


def _link(reference: Path) -> Signals:
    numbers = Adaptation(200.0, 40.0, (2e-4, 0.01, 0.04), (0.5, 0.15, 1.85))
    return simulate_link(numbers, (0.51, 0.16, 1.86), reference, 10.0)


def _operational_pd(K_D: float) -> Signals:
    goal = constant(ARM.tip(np.array([-math.pi / 3, -0.1, math.pi / 2]), np.zeros(3)).pose)
    return simulate_arm(free_space.operational_pd(goal, ARM, 50.0, K_D), goal, 8.0)


def _resolved(reference: Path) -> Signals:
    return simulate_arm(free_space.operational_inverse_dynamics(reference, ARM, 100.0, 15.0), reference, 3.0)


def _wall(stiffness: float, position: float, damping: float = 0.0) -> Wall:
    return Wall(stiffness, np.array([0.0, -1.0, 0.0]), -position, damping)


def _side_wall(stiffness: float, position: float = 0.0, damping: float = 0.0) -> Wall:
    """A wall at x = -position; by default through the tip's position at (-π/2, -0.2, -π/6)."""
    touch = ARM.tip(np.array([-math.pi / 2, -0.2, -math.pi / 6]), np.zeros(3)).pose
    return Wall(stiffness, np.array([-1.0, 0.0, 0.0]), position or -float(touch[0]), damping)


def _slanted_wall(stiffness: float, slide: float) -> Wall:
    """A wall of slanted normal through the tip's position at a position of the slide."""
    position = ARM.tip(np.array([0.0, slide, 0.0]), np.zeros(3)).pose[:3]
    return Wall(stiffness, SLANTED, float(SLANTED @ position))


def _compliance(wall: Wall, duration: float = 5.0) -> Signals:
    goal = constant(ARM.tip(np.array([0.0, -0.2, 0.0]), np.zeros(3)).pose)
    return simulate_arm(contact.compliance(goal, ARM, _six(50.0), _six(10.0)), goal, duration, wall)


FIGURE_TARGET = (
    _six(0.1, 0.5, 0.3, 1.0, 1.0, 1.0),
    _six(10.0, 25.0, 10.0, 10.0, 10.0, 10.0),
    _six(50.0, 75.0, 50.0, 50.0, 50.0, 50.0),
)
PRINTED_TARGET = _six(1.0, 0.5, 1.0, 1.0, 1.0, 1.0), _six(10.0), _six(50.0)


def _impedance(target: tuple[Array, Array, Array], wall: Wall, duration: float = 5.0) -> Signals:
    path = pose_path(ARM, quintic((0.0, 1.0), (HOME, (0.0, -0.2, 0.0))))
    return simulate_arm(contact.impedance(path, ARM, *target), path, duration, wall)


def _admittance(wall: Wall, held: bool, duration: float) -> Signals:
    times, points = [0.0, 1.5, 3.0], [HOME, (0.0, -0.25, 0.0), (0.0, -0.1, 0.0)]
    path = pose_path(ARM, quintic(times[:2], points[:2]) if held else quintic(times, points))
    frame = _six(1.0), _six(1.0, 10.0, 1.0, 1.0, 1.0, 1.0), _six(1.0, 20.0, 1.0, 1.0, 1.0, 1.0)
    controller = contact.admittance(path, ARM, frame, 50.0, 10.0)
    return simulate_arm(controller, path, duration, wall)


INNER = _six(0.5, 0.5, 0.5, 1.0, 1.0, 1.0), _six(100.0), _six(50.0)
PARALLEL_INNER = _six(1.0), _six(60.0), _six(40.0)
STIFF_INNER = _six(1.0), _six(160.0), _six(6400.0)


def _press(
    pursuit: Pursuit,
    desired: float,
    wall: Wall,
    duration: float,
    base: bool = False,
    inner: tuple[Array, Array, Array] = INNER,
) -> Signals:
    start = ARM.tip(np.zeros(3), np.zeros(3)).pose
    origin = start.copy()
    if base:
        origin[1] = 0.0
    controller = contact.force_loop(ARM, constant(origin), -desired * wall.normal, pursuit, inner)
    return simulate_arm(controller, constant(start), duration, wall)


def _parallel(
    wall: Wall,
    at_home: bool,
    duration: float,
    pursuit: Pursuit,
    inner: tuple[Array, Array, Array] = PARALLEL_INNER,
) -> Signals:
    desired = ARM.tip(np.array([-math.pi / 2, -0.1, -math.pi / 6]), np.zeros(3)).pose
    force = np.array([0.5, 0.0, 0.0])
    controller = contact.force_loop(ARM, constant(desired), force, pursuit, inner)
    start = HOME if at_home else (-math.pi / 2, -0.1, -math.pi / 6)
    return simulate_arm(controller, constant(desired), duration, wall, start)


_PD = np.array([50.0, 500.0, 50.0]), np.array([15.0, 150.0, 15.0])
_PD_PRINTED = np.full(3, 50.0), np.full(3, 10.0)
_AS_RUN = ((math.pi / 4, -0.2, math.pi / 3), *WAYPOINTS[1:])
_STOP = PERIOD + 1.0 / (80.0 * math.e)  # of an inner loop with double pole -80 rad/s


def _estimated(guess: float, speeds: Speeds) -> EstimatedPursuit:
    return EstimatedPursuit(10.0, 0.3, speeds, FittedSurface(guess, 0.05, 200.0))


RUNS: Mapping[str, Callable[[], Signals]] = {
    "pd": partial(_pd, constant(GOAL), *_PD, 5.0),
    "pd_printed": partial(_pd, constant(GOAL), *_PD_PRINTED, 5.0),
    "pd_without_gravity": partial(_pd, constant(GOAL), *_PD, 5.0, "none"),
    "pd_desired_gravity": partial(_pd, constant(GOAL), *_PD, 5.0, "desired"),
    "pd_sine": partial(_pd, sine(GOAL, 0.1, 2 * math.pi), *_PD, 3.0),
    "inverse_dynamics": partial(_computed, STEP_PATH, 50.0, 15.0, 5.0),
    "inverse_dynamics_printed": partial(_computed, STEP_PATH, 50.0, 10.0, 5.0),
    "inverse_dynamics_from_home": partial(_computed, HOME_PATH, 50.0, 10.0, 5.0),
    "inverse_dynamics_constant": partial(_computed, constant(GOAL), 50.0, 10.0, 3.0),
    "link_mass_errors": partial(_computed, STEP_PATH, 50.0, 15.0, 8.0, WRONG),
    "link_mass_errors_printed": partial(_computed, STEP_PATH, 50.0, 10.0, 5.0, WRONG),
    "link_mass_errors_from_home": partial(_computed, HOME_PATH, 50.0, 10.0, 5.0, WRONG),
    "link_mass_errors_fast": partial(_computed, HOME_PATH, 500.0, 35.0, 5.0, WRONG),
    "inverse_dynamics_fast": partial(_computed, STEP_PATH, 500.0, 35.0, 3.0),
    "adaptive": partial(_link, sine((0.0,), 1.0, 3.14)),
    "adaptive_printed": partial(_link, sine((0.0,), 1.0, 2 * math.pi)),
    "adaptive_square": partial(_link, square(1.0)),
    "operational_pd": partial(_operational_pd, 15.0),
    "operational_pd_printed": partial(_operational_pd, 10.0),
    "pose_quintic": lambda: _resolved(pose_quintic(ARM, TIMES, WAYPOINTS)),
    "pose_quintic_as_run": lambda: _resolved(pose_quintic(ARM, TIMES, _AS_RUN)),
    "pose_of_joint_quintic": lambda: _resolved(pose_path(ARM, STEP_PATH)),
    "compliance_soft": partial(_compliance, _wall(1.0, -0.44)),
    "compliance_equal": partial(_compliance, _wall(50.0, -0.44)),
    "compliance_stiff": partial(_compliance, _wall(1000.0, -0.44)),
    "compliance_damped": partial(_compliance, _wall(1000.0, -0.44, 20.0), 2.0),
    "compliance_slanted": partial(_compliance, _slanted_wall(50.0, -0.1), 2.0),
    "impedance_soft": partial(_impedance, FIGURE_TARGET, _wall(1.0, -0.44)),
    "impedance_soft_printed": partial(_impedance, PRINTED_TARGET, _wall(1.0, -0.44)),
    "impedance_equal": partial(_impedance, FIGURE_TARGET, _wall(50.0, -0.44)),
    "impedance_equal_printed": partial(_impedance, PRINTED_TARGET, _wall(50.0, -0.44)),
    "impedance_stiff": partial(_impedance, FIGURE_TARGET, _wall(1000.0, -0.44)),
    "impedance_stiff_printed": partial(_impedance, PRINTED_TARGET, _wall(1000.0, -0.44)),
    "impedance_slanted": partial(_impedance, FIGURE_TARGET, _slanted_wall(50.0, -0.1), 2.0),
    "impedance_slanted_printed": partial(_impedance, PRINTED_TARGET, _slanted_wall(50.0, -0.1), 2.0),
    "admittance_soft": partial(_admittance, _wall(1.0, -0.34), False, 5.0),
    "admittance_soft_hold": partial(_admittance, _wall(1.0, -0.34), True, 8.0),
    "admittance_equal": partial(_admittance, _wall(50.0, -0.34), False, 5.0),
    "admittance_equal_hold": partial(_admittance, _wall(50.0, -0.34), True, 8.0),
    "admittance_stiff": partial(_admittance, _wall(1000.0, -0.34), False, 5.0),
    "admittance_stiff_hold": partial(_admittance, _wall(1000.0, -0.34), True, 8.0),
    "admittance_slanted": partial(_admittance, _slanted_wall(50.0, -0.2), True, 2.5),
    "force_integral": lambda: _press(SteadyPursuit(10.0, 5.0), 1.0, _wall(5.0, -0.44), 15.0),
    "force_integral_base": lambda: _press(SteadyPursuit(10.0, 5.0), 1.0, _wall(5.0, -0.44), 15.0, True),
    "force_proportional": lambda: _press(SteadyPursuit(10.0, 0.0), 1.0, _wall(5.0, -0.44), 15.0),
    "force_proportional_base": lambda: _press(SteadyPursuit(10.0, 0.0), 1.0, _wall(5.0, -0.44), 15.0, True),
    "force_slanted": lambda: _press(SteadyPursuit(10.0, 5.0), 1.0, _slanted_wall(5.0, -0.1), 1.0),
    "force_estimated": lambda: _press(
        _estimated(100.0, Speeds(0.005, 0.055, 200.0, _STOP, 0.08)),
        1.0,
        _wall(200.0, -0.5, 8.0),
        2.0,
        inner=STIFF_INNER,
    ),
    "parallel": lambda: _parallel(_side_wall(50.0), False, 15.0, SteadyPursuit(15.0, 15.0)),
    "parallel_as_run": lambda: _parallel(_side_wall(1.0), True, 15.0, SteadyPursuit(15.0, 15.0)),
    "parallel_estimated": lambda: _parallel(
        # the guess of 1000 N/m is limited by the stiffest surface
        _side_wall(200.0, 0.4, 2.0),
        False,
        1.0,
        _estimated(200.0, Speeds(0.05, 0.05)),
        STIFF_INNER,
    ),
}
"""Every run with a check against numbers of this computation."""
