"""Errata of the report in centres of mass, inertia tensors and the inertia matrix."""

import dataclasses
import math

import numpy as np
import pytest

from prp_gym.robot import NOMINAL, REPORT, PRPArm, RobotParameters
from tests.support.pinocchio_model import Array, PinocchioArm, per_row, random_states

ARM, REPORT_ARM, PINOCCHIO = PRPArm(), PRPArm(REPORT), PinocchioArm()
A_1, SLIDE, A_3, HEIGHT = 0.40, 0.30, 0.24, 0.15
R_1, H_1, R_3, H_3 = 0.02, 0.35, 0.02, 0.24
A_2, B_2, C_2 = 0.30, 0.03, 0.03
MASS_1, MASS_2, MASS_3 = NOMINAL.link_mass
EXACT = 1e-12  # a few dozen operations of 1e-16 on numbers of order one
DIFFERENCE = 1e-9  # central differences by 1e-5: truncation and rounding of 1e-11 each
NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)  # exact up to the seventh power


def mean_square(length: float) -> float:
    """Mean of x² over a rod of a length about its middle."""
    return float((WEIGHTS * (NODES * length / 2) ** 2).sum() / WEIGHTS.sum())


def mean_square_of_disc(radius: float) -> float:
    """Mean of y² over a disc: over the angle a half, over the radius by quadrature."""
    ring = (NODES + 1) * radius / 2
    return float(0.5 * (WEIGHTS * ring * ring**2).sum() / (WEIGHTS * ring).sum())


def about_vertical(arm: PRPArm) -> float:
    """What b_11 has without q_2 and C_3; the report's T prints half of it, 0.248."""
    return float(arm.inertia_matrix((0.0, 0.0, math.pi / 2))[0, 0])


def squared_cosine(arm: PRPArm) -> float:
    """What b_11 has times C_3²; the report's T prints half of it, 0.0237."""
    stretched, folded = arm.inertia_matrix([(0.0, 0.0, 0.0), (0.0, 0.0, math.pi)])[:, 0, 0]
    return float((stretched + folded) / 2) - about_vertical(arm)


def b_33(arm: PRPArm) -> float:
    return float(arm.inertia_matrix((0.0, 0.0, 0.0))[2, 2])


def with_moments(across_1: float, box: float, across_3: float) -> PRPArm:
    """The report's arm with other moments across the cylinders and of the box about the vertical."""
    (axial_1, _, _), (_, slide, _), (_, axial_3, _) = REPORT.link_inertia
    inertia = ((axial_1, across_1, across_1), (box, slide, box), (across_3, axial_3, across_3))
    return PRPArm(dataclasses.replace(REPORT, link_inertia=inertia))


def test_printed_moment_across_a_cylinder_is_more_than_any_mass_of_its_length_has() -> None:
    for link, radius, length in ((0, R_1, H_1), (2, R_3, H_3)):
        mass = NOMINAL.link_mass[link]
        across = mass * (mean_square(length) + mean_square_of_disc(radius))
        printed = mass * (3 * radius**2 + length**2) / 2
        assert NOMINAL.link_inertia[link][2] == pytest.approx(across, rel=EXACT)
        assert printed == pytest.approx(6 * across, rel=EXACT)
        # all of the mass on the rims of the two ends would have h²/4 + r²/2
        assert printed > mass * (length**2 / 4 + radius**2 / 2)


def test_printed_kinetic_energy_counts_the_parallel_axis_twice() -> None:
    right_3, right_1 = (m * (3 * R_1**2 + h**2) / 12 for m, h in ((MASS_3, H_3), (MASS_1, H_1)))
    shifted = with_moments(right_1 + MASS_1 * H_1**2 / 4, 1e-3, right_3 + MASS_3 * H_3**2 / 4)
    # link 3 about joint 3's axis, by quadrature along the rod from 0 to a_3 and over its section
    along = mean_square(H_3) + (A_3 - H_3 / 2) ** 2
    about_joint_3 = MASS_3 * (along + mean_square_of_disc(R_3))
    assert b_33(ARM) == pytest.approx(about_joint_3, rel=EXACT)
    assert b_33(shifted) == pytest.approx(about_joint_3 + MASS_3 * H_3**2 / 4, rel=EXACT)
    # with the factor 1/2 of the cylinders these are the printed numbers, each to half its last digit
    assert b_33(REPORT_ARM) / 2 == pytest.approx(0.02378, rel=0, abs=5e-6)
    assert squared_cosine(REPORT_ARM) / 2 == pytest.approx(0.0237, rel=0, abs=5e-5)
    assert about_vertical(REPORT_ARM) / 2 == pytest.approx(0.248, rel=0, abs=5e-4)
    assert b_33(ARM) / 2 == pytest.approx(0.007887, rel=0, abs=5.1e-7)
    assert squared_cosine(ARM) / 2 == pytest.approx(0.007805, rel=0, abs=5.1e-7)
    assert about_vertical(ARM) / 2 == pytest.approx(0.20177, rel=0, abs=5.1e-6)
    q = random_states(32, 20)[0]
    B = per_row(PINOCCHIO.inertia_matrix, q)
    np.testing.assert_allclose(ARM.inertia_matrix(q), B, rtol=0, atol=EXACT)


def test_printed_energy_takes_the_box_about_its_long_axis_for_the_vertical() -> None:
    vertical = MASS_2 * (mean_square(A_2) + mean_square(B_2))
    assert NOMINAL.link_inertia[1][2] == pytest.approx(vertical, rel=EXACT)
    assert vertical == pytest.approx(0.0055426, rel=0, abs=5.1e-8)
    along = MASS_2 * (mean_square(B_2) + mean_square(C_2))
    assert along == pytest.approx(1.0976e-4, rel=0, abs=5.1e-9)
    shifted = MASS_2 * (3 * A_2**2 + B_2**2 + C_2**2) / 12  # the first entry of the printed I_l2
    across_1, across_3 = REPORT.link_inertia[0][2], REPORT.link_inertia[2][2]
    halves = [about_vertical(with_moments(across_1, box, across_3)) / 2 for box in (along, vertical, shifted)]
    # of the three moments that the text has, only the wrong one gives the printed 0.248
    assert [abs(half - 0.248) < 5e-4 for half in halves] == [True, False, False]
    assert halves[1] - halves[0] == pytest.approx((vertical - along) / 2, rel=1e-9)  # a small difference


def test_printed_center_of_link_1_is_not_the_one_that_was_used() -> None:
    def moved(parameters: RobotParameters, center: float) -> float:
        geometry = dataclasses.replace(parameters.geometry, first_link_center_of_mass=center)
        return about_vertical(PRPArm(dataclasses.replace(parameters, geometry=geometry)))

    text = A_1 - H_1 / 2
    assert text == pytest.approx(0.225, abs=EXACT)
    assert NOMINAL.geometry.first_link_center_of_mass == 0.20
    assert moved(REPORT, 0.20) / 2 == pytest.approx(0.248, rel=0, abs=5e-4)  # the printed digits
    assert abs(moved(REPORT, text) / 2 - 0.248) > 6e-3
    shift = MASS_1 * (text**2 - 0.20**2)
    assert moved(NOMINAL, text) - moved(NOMINAL, 0.20) == pytest.approx(shift, rel=1e-9)
    assert (moved(NOMINAL, 0.20), moved(NOMINAL, text)) == pytest.approx((0.403534, 0.416198), abs=5.1e-7)


def centers(q: Array) -> Array:
    """Centres of mass of links 2 and 3, (2, ..., 3), from the frames."""
    frames = ARM.transforms(q)
    second = frames[..., 2, :3, 3] + A_2 / 2 * frames[..., 2, :3, 1]
    third = frames[..., 3, :3, 3] - H_3 / 2 * frames[..., 3, :3, 0]
    return np.stack([second, third])


def test_printed_partial_jacobians_are_not_the_slopes_of_the_centers_of_mass() -> None:
    q = random_states(30, 50)[0]
    step = 1e-5 * np.eye(3)
    slopes = np.stack([(centers(q + h) - centers(q - h)) / 2e-5 for h in step], axis=-1)  # (2, 50, 3, 3)
    s_1, c_1, s_3, c_3 = np.sin(q[:, 0]), np.cos(q[:, 0]), np.sin(q[:, 2]), np.cos(q[:, 2])
    zero, reach, lever = np.zeros(50), q[:, 1] + SLIDE - A_2 / 2, A_3 - H_3 / 2
    around = np.stack([-A_1 * s_1, A_1 * c_1, zero], axis=-1)
    printed_2 = np.stack([reach * c_1, reach * s_1, zero], axis=-1)
    printed_3 = lever * np.stack([c_1 * c_3, s_1 * c_3, zero], axis=-1)
    stretched = np.stack([(q[:, 1] + SLIDE) * c_1, (q[:, 1] + SLIDE) * s_1, zero], axis=-1)
    for printed, right, slope in (
        (printed_2, printed_2 + around, slopes[0, :, :, 0]),
        (printed_3, printed_3 + stretched + around, slopes[1, :, :, 0]),
        (
            lever * np.stack([s_1 * s_3, -c_1 * s_3, c_3], axis=-1),
            lever * np.stack([-s_1 * s_3, c_1 * s_3, c_3], axis=-1),
            slopes[1, :, :, 2],
        ),
    ):
        assert np.abs(printed - slope).max() > 0.1
        np.testing.assert_allclose(right, slope, rtol=0, atol=DIFFERENCE)
    # the printed first column of link 2 would leave b_12 without -m_2 a_1, which the printed B_2 does have
    push = np.stack([s_1, -c_1, zero], axis=-1)
    np.testing.assert_allclose((printed_2 * push).sum(axis=-1), 0.0, rtol=0, atol=EXACT)
    np.testing.assert_allclose((slopes[0, :, :, 0] * push).sum(axis=-1), -A_1, rtol=0, atol=DIFFERENCE)


def test_printed_symbols_of_the_inertia_matrix_do_not_give_its_printed_numbers() -> None:
    B_1 = MASS_1 * ((A_1 - H_1) ** 2 + R_1**2) / 2
    # less than the same mass has as a point at its centre, where the text or where the code puts it
    assert B_1 < 0.03 * MASS_1 * (A_1 - H_1 / 2) ** 2
    assert B_1 < 0.04 * MASS_1 * 0.20**2

    def k_as_printed(slide: float, cosine: float) -> float:
        second = A_1**2 + (SLIDE + slide - A_2 / 2) ** 2 + (A_2**2 + C_2**2) / 12
        third = A_1**2 + (SLIDE + slide - (H_3 / 2 - A_3) * cosine) ** 2 + (H_3**2 + R_3**2) / 12
        return B_1 + MASS_2 * second + MASS_3 * third

    assert k_as_printed(0.0, 0.0) == pytest.approx(0.3491, rel=0, abs=5.1e-5)
    assert abs(k_as_printed(0.0, 0.0) - 2 * 0.248) > 0.1
    printed_b_33 = A_3**2 - A_3 * H_3 + H_3**2 + R_3**2 / 2  # without its mass
    assert printed_b_33 == pytest.approx(0.0578, rel=EXACT)
    assert abs(MASS_3 * printed_b_33 - 0.04757) > 3e-4  # with it, still not the printed number
    right_b_33 = MASS_3 * (A_3**2 - A_3 * H_3 + H_3**2 / 3 + R_3**2 / 4)
    q = random_states(31, 50)[0]
    B = per_row(PINOCCHIO.inertia_matrix, q)
    np.testing.assert_allclose(B[:, 2, 2], right_b_33, rtol=EXACT)
    # its last term stands still, where link 3 turns about the vertical by its axis or across it
    s_3, c_3 = np.sin(q[:, 2]), np.cos(q[:, 2])
    first = MASS_1 * (0.20**2 + (3 * R_1**2 + H_1**2) / 12)
    second = A_1**2 + (SLIDE + q[:, 1] - A_2 / 2) ** 2 + (A_2**2 + B_2**2) / 12
    spin = R_3**2 / 2 * s_3**2 + (3 * R_3**2 + H_3**2) / 12 * c_3**2
    third = A_1**2 + (SLIDE + q[:, 1] + (A_3 - H_3 / 2) * c_3) ** 2 + spin
    k = first + MASS_2 * second + MASS_3 * third
    np.testing.assert_allclose(B[:, 0, 0], k, rtol=EXACT)
    np.testing.assert_allclose(ARM.inertia_matrix(q)[:, 0, 0], k, rtol=EXACT)
