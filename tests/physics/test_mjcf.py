"""The generated MuJoCo model against the closed form, and what its document must contain."""

from dataclasses import replace

import numpy as np
import pytest

from prp_gym.errors import InvalidValueError
from prp_gym.physics import TIP_RADIUS, Physics, PhysicsSettings, to_mjcf
from prp_gym.physics.scene import FIXED_CAMERAS
from prp_gym.robot import NOMINAL, REPORT, PRPArm, RobotParameters
from tests.support.pinocchio_model import Array, random_arm, random_states

# isort: split
import mujoco  # after prp_gym, which chooses how MuJoCo draws

COUNT = 40
ROUNDING = 2e-14  # a few dozen operations on numbers of order one
ARMS = {
    "nominal": NOMINAL,
    "report": REPORT,
    "scaled": NOMINAL.scaled((0.7, 1.3, 0.9)),
    "light": NOMINAL.with_masses((0.9, 0.5, 0.7)),
    "random": random_arm(3)[0],
    "weightless": replace(NOMINAL, gravity=0.0),
}
WORLDS = {
    "plain": PhysicsSettings(),
    "surface": PhysicsSettings(surface=True),
    "rough surface": PhysicsSettings(surface=True, surface_friction=0.4),
    "free joints": PhysicsSettings(joint_stops=False, timestep=0.002),
}
COMPILED_FIELDS = (
    "body_mass",
    "body_inertia",
    "body_ipos",
    "body_pos",
    "body_invweight0",
    "jnt_axis",
    "jnt_range",
    "jnt_limited",
    "jnt_solref",
    "dof_damping",
    "dof_frictionloss",
    "pair_solref",
    "pair_solimp",
    "pair_friction",
    "actuator_gear",
    "site_pos",
    "cam_pos",
    "sensor_type",
)


@pytest.fixture(params=list(ARMS))
def parameters(request: pytest.FixtureRequest) -> RobotParameters:
    return ARMS[str(request.param)]


def worlds_at_random_states(parameters: RobotParameters, seed: int) -> tuple[Physics, Array, Array]:
    """Simulations at random states within and beyond the joint limits, without stops."""
    q, velocity, _, _ = random_states(seed, COUNT)
    physics = Physics(parameters, PhysicsSettings(joint_stops=False), num_simulations=COUNT)
    physics.reset(np.arange(COUNT), q, velocity)
    return physics, q, velocity


def test_inertia_matrix_is_the_closed_form(parameters: RobotParameters) -> None:
    physics, q, _ = worlds_at_random_states(parameters, 1)
    full = np.empty((COUNT, 3, 3))
    for row in range(COUNT):
        mujoco.mj_fullM(physics.model(row), physics.data(row), full[row])
    expected = PRPArm(parameters).inertia_matrix(q)
    np.testing.assert_allclose(full, expected, rtol=0, atol=ROUNDING)


def test_bias_force_is_the_closed_form(parameters: RobotParameters) -> None:
    physics, q, velocity = worlds_at_random_states(parameters, 2)
    bias = np.array([physics.data(row).qfrc_bias for row in range(COUNT)])
    expected = PRPArm(parameters).bias_force(q, velocity)
    # forces of up to 50
    np.testing.assert_allclose(bias, expected, rtol=0, atol=10 * ROUNDING)


def test_tip_site_and_its_jacobian_are_the_closed_form(parameters: RobotParameters) -> None:
    physics, q, _ = worlds_at_random_states(parameters, 3)
    arm = PRPArm(parameters)
    position, jacobian = np.empty((COUNT, 3)), np.empty((COUNT, 6, 3))
    for row in range(COUNT):
        model, data = physics.model(row), physics.data(row)
        site = model.site("tip").id
        position[row] = data.site_xpos[site]
        mujoco.mj_jacSite(model, data, jacobian[row, :3], jacobian[row, 3:], site)
    np.testing.assert_allclose(position, arm.forward_kinematics(q)[:, :3], rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(jacobian, arm.geometric_jacobian(q), rtol=0, atol=ROUNDING)


def test_energies_are_the_closed_form(parameters: RobotParameters) -> None:
    physics, q, velocity = worlds_at_random_states(parameters, 4)
    energy = np.empty((COUNT, 2))
    for row in range(COUNT):
        model, data = physics.model(row), physics.data(row)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        energy[row] = data.energy
    arm = PRPArm(parameters)
    expected = np.stack([arm.potential_energy(q), arm.kinetic_energy(q, velocity)], axis=-1)
    # sums of energies of up to 50 J
    np.testing.assert_allclose(energy, expected, rtol=0, atol=10 * ROUNDING)


def test_acceleration_without_friction_is_the_closed_form(parameters: RobotParameters) -> None:
    physics, q, velocity = worlds_at_random_states(parameters, 5)
    torque = np.random.default_rng(5).uniform(-10.0, 10.0, size=(COUNT, 3))
    physics.set_torque(torque)
    acceleration = np.array([physics.data(row).qacc for row in range(COUNT)])
    expected = PRPArm(parameters).forward_dynamics(q, velocity, torque)
    # B's condition number of up to 200 multiplies the rounding; accelerations reach 1e3
    np.testing.assert_allclose(acceleration, expected, rtol=1e-12, atol=1e-11)


@pytest.mark.parametrize("world", WORLDS.values(), ids=list(WORLDS))
def test_document_compiles_and_survives_export(parameters: RobotParameters, world: PhysicsSettings) -> None:
    text = to_mjcf(parameters, world)
    exported = mujoco.MjSpec.from_string(text).to_xml()
    first, second = (mujoco.MjModel.from_xml_string(document) for document in (text, exported))
    for name in COMPILED_FIELDS:
        # the export prints six digits, some of numbers derived from others
        np.testing.assert_allclose(
            getattr(second, name), getattr(first, name), rtol=2e-5, atol=2e-8, err_msg=name
        )


def test_document_is_that_of_the_simulation() -> None:
    world = PhysicsSettings(surface=True, surface_friction=0.2)
    compiled = mujoco.MjModel.from_xml_string(to_mjcf(REPORT, world))
    simulated = Physics(REPORT, world).model()
    for name in COMPILED_FIELDS:
        np.testing.assert_array_equal(getattr(compiled, name), getattr(simulated, name), err_msg=name)


def test_defaults_are_the_nominal_arm_in_the_default_world() -> None:
    assert to_mjcf() == to_mjcf(NOMINAL, PhysicsSettings())
    assert to_mjcf() != to_mjcf(REPORT)


def test_every_number_of_the_parameters_arrives_with_all_digits() -> None:
    arm = replace(
        NOMINAL.scaled((0.1 + 0.2, 1 / 3, 2 / 3)),
        viscous_friction=(1 / 7, 2 / 7, 3 / 7),
        coulomb_friction=(1 / 9, 0.0, 2 / 9),
        joint_lower=(-1 / 3, -0.2, -2 / 3),
        joint_upper=(1 / 3, -0.1, 2 / 3),
        gravity=29 / 3,
    )
    model = mujoco.MjModel.from_xml_string(to_mjcf(arm))
    links = [model.body(name).id for name in ("link_1", "link_2", "link_3")]
    np.testing.assert_array_equal(model.body_mass[links], arm.link_mass)
    np.testing.assert_array_equal(model.body_inertia[links], arm.link_inertia)
    np.testing.assert_array_equal(model.dof_damping, arm.viscous_friction)
    np.testing.assert_array_equal(model.dof_frictionloss, arm.coulomb_friction)
    np.testing.assert_array_equal(model.jnt_range, np.transpose([arm.joint_lower, arm.joint_upper]))
    np.testing.assert_array_equal(model.opt.gravity, (0.0, 0.0, -29 / 3))


@pytest.mark.parametrize("stops", [True, False])
def test_joints_motors_and_stops(stops: bool) -> None:
    model = mujoco.MjModel.from_xml_string(to_mjcf(NOMINAL, PhysicsSettings(joint_stops=stops)))
    names = [f"joint_{index}" for index in (1, 2, 3)]
    assert [model.joint(index).name for index in range(model.njnt)] == names
    assert [model.actuator(index).name for index in range(model.nu)] == names
    kinds = [mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE]
    assert model.jnt_type.tolist() == [int(kind) for kind in kinds]
    assert model.jnt_limited.tolist() == [stops] * 3
    assert not model.actuator_ctrllimited.any()
    assert not model.actuator_forcelimited.any()
    np.testing.assert_array_equal(model.actuator_gear[:, 0], np.ones(3))


def test_joint_stops_hold_and_are_reported() -> None:
    pushes = np.array([[20.0, 0, 0], [-20.0, 0, 0], [0, 30.0, 0], [0, -30.0, 0], [0, 0, 5.0], [0, 0, -5.0]])
    starts = np.array(
        [[3.0, -0.1, 0], [-3.0, -0.1, 0], [0, -0.05, 0], [0, -0.25, 0], [0, 0, 3.0], [0, 0, -3.0]]
    )
    ids, joint = np.arange(6), np.arange(6) // 2
    stopped, free = (
        Physics(settings=world, num_simulations=6) for world in (WORLDS["plain"], WORLDS["free joints"])
    )
    for physics in (stopped, free):
        physics.reset(ids, starts, np.zeros((6, 3)))
        assert not physics.joints_at_stop[ids, joint].any()
        physics.set_torque(pushes)
        physics.advance(1000)
    limits = np.stack([NOMINAL.joint_lower, NOMINAL.joint_upper])[1 - ids % 2, joint]
    assert stopped.joints_at_stop[ids, joint].all()
    # stops are stiff, not rigid
    assert (np.abs(stopped.joint_position[ids, joint] - limits) < 0.02).all()
    assert (np.abs(free.joint_position[ids, joint] - limits) > 0.5).all()
    assert not free.joints_at_stop.any()
    assert not free.stop_violation.any()
    beyond = np.abs(stopped.joint_position - limits[:, None])[ids, joint]
    # differences of angles of about 3
    np.testing.assert_allclose(stopped.stop_violation[ids, joint], -beyond, rtol=0, atol=1e-15)


def test_world_has_the_declared_timestep_and_integrator() -> None:
    model = mujoco.MjModel.from_xml_string(to_mjcf(NOMINAL, PhysicsSettings(timestep=0.0025)))
    assert model.opt.timestep == 0.0025
    assert int(model.opt.integrator) == int(mujoco.mjtIntegrator.mjINT_EULER)


def test_cameras_are_fixed_and_the_top_one_looks_straight_down() -> None:
    model = mujoco.MjModel.from_xml_string(to_mjcf())
    assert tuple(model.camera(index).name for index in range(model.ncam)) == FIXED_CAMERAS
    assert (model.cam_bodyid == 0).all()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    backward = data.cam_xmat[model.camera("top").id].reshape(3, 3)[:, 2]
    np.testing.assert_allclose(backward, (0.0, 0.0, 1.0), rtol=0, atol=ROUNDING)


def test_only_the_tip_and_the_surface_can_touch() -> None:
    model = mujoco.MjModel.from_xml_string(to_mjcf(NOMINAL, PhysicsSettings(surface=True)))
    assert not model.geom_contype.any()
    assert not model.geom_conaffinity.any()
    assert model.npair == 1
    touching = {model.geom(int(model.pair_geom1[0])).name, model.geom(int(model.pair_geom2[0])).name}
    assert touching == {"tip", "surface"}
    assert model.geom("tip").size[0] == TIP_RADIUS
    assert mujoco.MjModel.from_xml_string(to_mjcf()).npair == 0


@pytest.mark.parametrize(("friction", "dimensions"), [(0.0, 1), (0.35, 3)])
def test_surface_friction_arrives(friction: float, dimensions: int) -> None:
    world = PhysicsSettings(surface=True, surface_friction=friction)
    model = mujoco.MjModel.from_xml_string(to_mjcf(NOMINAL, world))
    assert model.pair_dim.tolist() == [dimensions]
    if dimensions == 3:
        np.testing.assert_array_equal(model.pair_friction[0, :2], (friction, friction))


@pytest.mark.parametrize("kind", ["viscous", "coulomb", "both"])
def test_joint_friction_takes_the_energy_of_its_equation(kind: str) -> None:
    viscous, coulomb = np.array([0.1, 0.2, 0.01]), np.array([0.05, 0.2, 0.02])
    viscous *= kind != "coulomb"
    coulomb *= kind != "viscous"
    parameters = replace(
        NOMINAL,
        gravity=0.0,
        viscous_friction=tuple(viscous.tolist()),
        coulomb_friction=tuple(coulomb.tolist()),
    )
    arm, physics = PRPArm(parameters), Physics(parameters, PhysicsSettings(joint_stops=False))
    physics.reset(np.arange(1), np.array([[0.0, -0.1, 0.5]]), np.array([[2.0, 1.0, 4.0]]))
    before, spent = arm.kinetic_energy(physics.joint_position, physics.joint_velocity)[0], 0.0
    for _ in range(500):
        speed = physics.joint_velocity[0].copy()
        physics.advance(1)
        speed = np.abs(speed + physics.joint_velocity[0]) / 2
        spent += physics.timestep * float((viscous * speed**2 + coulomb * speed).sum())
    lost = before - arm.kinetic_energy(physics.joint_position, physics.joint_velocity)[0]
    assert spent > 0.05
    # the integrator's own exchange of 1e-4 J; the solver softens Coulomb friction below 2 mrad/s
    assert lost == pytest.approx(spent, rel=0.01)


@pytest.mark.parametrize("timestep", [0.0, -0.001, float("nan")])
def test_timestep_must_be_positive(timestep: float) -> None:
    with pytest.raises(InvalidValueError, match="timestep") as caught:
        PhysicsSettings(timestep=timestep)
    assert caught.value.unit == "s"


@pytest.mark.parametrize("friction", [-0.1, float("nan")])
def test_surface_friction_must_not_be_negative(friction: float) -> None:
    with pytest.raises(InvalidValueError, match="surface_friction"):
        PhysicsSettings(surface=True, surface_friction=friction)
