"""Derivatives of the arm's step and measurement against differences, in every kind of world."""

import ctypes
import itertools
from typing import Any

import numpy as np
import pytest

from prp_gym.physics import PhysicsSettings
from prp_gym.physics.compiled_arm import CompiledArm
from prp_gym.physics.compiled_arm_source import PLANT_SIZE, SURFACE_SIZE, arm_source
from prp_gym.physics.derivatives_source import arm_derivatives_source
from prp_gym.robot.parameters import NOMINAL
from prp_gym.symbolic.compiler import load_library
from tests.physics.test_compiled_arm import random_surface
from tests.support.compiler import needs_compiler
from tests.support.differences import WIDTH, differences
from tests.support.pinocchio_model import Array

pytestmark = needs_compiler

COUNT, TIMESTEP = 24, 0.001
WORLDS = list(itertools.product((False, True), repeat=3))  # joint stops, surface, Coulomb friction
SPREAD = np.array([4.0, 20.0, 2.0])  # of random torques [N m, N, N m]
ROUNDING = 4e-8
"""Largest deviation of a difference quotient, relative to 1 + |derivative|: rounding over `WIDTH`, at a stop
of reference accelerations of 1e3 rad/s² and weights of 100 times the inertia. Without stops it is 1e-10."""
FREE, CURVED, LOW, HIGH = 0, 1, 2, 3  # zones of a constraint
SIZES = {"position": 3, "velocity": 3, "torque": 3, "plant": PLANT_SIZE, "surface": SURFACE_SIZE}

ENTRY = """
void zones(const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, double *zone)
{
    prp_minimum m;
    prp_find(world, q, v, tau, plant, surface, &m);
    for (int i = 0; i < PRP_ROWS; i++)
        zone[i] = 0.0;
    for (int i = 0; i < m.c.count; i++) {
        double stiff;
        prp_force(&m.c, i, prp_dot3(m.c.jacobian[i], m.a) - m.c.reference[i], &stiff);
        zone[m.c.row[i]] = stiff != 0.0 ? 1.0 : m.c.force[i] == 0.0 ? 0.0 : m.c.force[i] < 0.0 ? 2.0 : 3.0;
    }
}
"""


class Arms:
    """Random arms, some at their stops and some in contact, and the functions to test."""

    def __init__(self, stops: bool, surface: bool, coulomb: bool) -> None:
        rng = np.random.default_rng(7)
        self.physics = CompiledArm(PhysicsSettings(TIMESTEP, stops, surface), COUNT)
        self.library = load_library(arm_source(TIMESTEP) + arm_derivatives_source(TIMESTEP) + ENTRY)
        low, high = np.array(NOMINAL.joint_lower), np.array(NOMINAL.joint_upper)
        q = rng.uniform([-2.0, -0.3, -3.0], [2.0, 0.0, 3.0], (COUNT, 3))
        beyond = rng.uniform(-5e-4, 2e-3, (COUNT, 3))
        at_stop = rng.random((COUNT, 3)) < 0.4 * stops
        q = np.where(at_stop, np.where(rng.random((COUNT, 3)) < 0.5, low - beyond, high + beyond), q)
        speed = np.where(rng.random((COUNT, 1)) < 0.5, 0.002, 1.0)
        ids = np.arange(COUNT)
        factors, viscous = rng.uniform(0.7, 1.4, (COUNT, 3)), rng.uniform(0.0, 0.5, (COUNT, 3))
        self.physics.set_dynamics(ids, factors, viscous, rng.uniform(0.05, 0.5, (COUNT, 3)) * coulomb)
        if surface:
            self.physics.set_surface(ids, random_surface(rng, q))
        self.physics.reset(ids, q, speed * rng.normal(size=(COUNT, 3)))
        self.physics.set_torque(rng.normal(size=(COUNT, 3)) * SPREAD * rng.choice([0.02, 1.0], (COUNT, 1)))
        self.width = self.physics.measurement_size

    def given(self, row: int) -> Array:
        """Position, velocity, torque, plant and surface of one arm."""
        names = ("position", "velocity", "torque", "plants", "surfaces")
        return np.concatenate([self.physics.arrays[name][row] for name in names])

    def call(self, name: str, given: Array, weights: tuple[Array, ...], *sizes: int) -> list[Array]:
        """The results of a compiled function of one arm."""
        parts = [np.ascontiguousarray(part) for part in np.split(given, np.cumsum(list(SIZES.values()))[:-1])]
        results = [np.full(size, np.nan) for size in sizes]
        arrays = [np.ascontiguousarray(weight) for weight in weights]
        addresses = [ctypes.c_void_p(array.ctypes.data) for array in (*parts, *arrays, *results)]
        function: Any = getattr(self.library, name)
        function.restype = None
        function(ctypes.byref(self.physics.world), *addresses)
        return results

    def advanced(self, given: Array, substeps: int) -> tuple[Array, Array]:
        """State after some steps, and its measurement."""
        parts = [part.copy() for part in np.split(given, np.cumsum(list(SIZES.values()))[:-1])]
        measured, beyond, lost = np.zeros(self.width), np.zeros(3), np.zeros(1, dtype=np.uint8)
        world, arrays = self.physics.world, [*parts, measured, beyond]
        world.substeps = substeps
        addresses = (ctypes.c_void_p(array.ctypes.data) for array in arrays)
        function, last = self.library.prp_advance, ctypes.c_void_p(lost.ctypes.data)
        function(ctypes.c_long(0), ctypes.c_long(1), None, ctypes.byref(world), *addresses, last)
        return np.concatenate(parts[:2]), measured

    def zones(self, given: Array) -> Array:
        """The zone of each constraint: friction (3), stops (3), surface."""
        return self.call("zones", given, (), 7)[0]


def crossings(arms: Arms, at: Array, count: int) -> bool:
    """Whether a zone changes within the differences by the first numbers."""
    here = arms.zones(at)
    for index, share in itertools.product(range(count), (-2.0, 2.0)):
        moved = at.copy()
        moved[index] += share * WIDTH * max(1.0, abs(at[index]))
        if (arms.zones(moved) != here).any():
            return True
    return False


def deviation(found: Array, expected: Array) -> float:
    return float((np.abs(found - expected) / (1.0 + np.abs(expected))).max())


@pytest.mark.parametrize(("stops", "surface", "coulomb"), WORLDS)
def test_derivatives_of_a_step_and_of_its_measurement(stops: bool, surface: bool, coulomb: bool) -> None:
    arms = Arms(stops, surface, coulomb)
    seen, crossed = [], 0
    for row in range(COUNT):
        at = arms.given(row)
        if crossings(arms, at, 9):
            crossed += 1
            continue
        seen.append(arms.zones(at))
        exact = [arms.call("prp_step_reverse", at, (unit[:3], unit[3:]), 3, 3, 3) for unit in np.eye(6)]
        found = np.array([np.concatenate(parts) for parts in exact])
        expected = differences(lambda state: arms.advanced(state, 1)[0], at)[:, :9]
        assert deviation(found, expected) < ROUNDING
        exact = [arms.call("prp_measured_reverse", at, (unit,), 3, 3, 3) for unit in np.eye(arms.width)]
        found = np.array([np.concatenate(parts) for parts in exact])
        expected = differences(lambda state: arms.advanced(state, 0)[1], at)[:, :9]
        scale = 1.0 + np.abs(expected).max()  # forces of stiff surfaces
        assert np.abs(found - expected).max() < ROUNDING * scale
    assert crossed <= 2  # random states are next to a switch as rarely as this
    zones = np.array(seen)
    active = np.count_nonzero(zones, axis=1)
    assert (np.count_nonzero(zones[:, 6] == CURVED) > 3) == surface
    assert (np.count_nonzero(zones[:, 3:6] == CURVED) > 3) == stops
    for zone in (CURVED, LOW, HIGH):
        assert (np.count_nonzero(zones[:, :3] == zone) > 3) == coulomb
    assert (active.max() >= 2) == (stops or coulomb)


@pytest.mark.parametrize(("stops", "surface", "coulomb"), WORLDS)
def test_derivatives_by_plant_and_surface(stops: bool, surface: bool, coulomb: bool) -> None:
    """Masses, friction and springs: what an identification estimates."""
    arms, crossed = Arms(stops, surface, coulomb), 0
    size = sum(SIZES.values())
    for row in range(COUNT):
        at = arms.given(row)
        if crossings(arms, at, size):
            crossed += 1
            continue
        for name, units, substeps in (("step", np.eye(6), 1), ("measured", np.eye(arms.width), 0)):
            weights = [(unit[:3], unit[3:]) if substeps else (unit,) for unit in units]
            found = np.array([arms.call(f"prp_{name}_adjoints", at, each, size)[0] for each in weights])
            expected = differences(lambda state, n=substeps: arms.advanced(state, n)[1 - n], at)  # type: ignore[misc]
            scale = 1.0 + np.abs(expected).max()
            assert np.abs(found - expected).max() < ROUNDING * scale
    assert crossed <= 2
