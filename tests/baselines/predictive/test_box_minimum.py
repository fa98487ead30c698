"""The minimum within bounds: its conditions of optimality, and a search over all sets of active bounds."""

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from prp_gym.baselines.predictive.box_minimum import box_minimum

Array = NDArray[np.float64]


def problems(size: int, count: int = 200) -> tuple[Array, Array, Array, Array]:
    """Random problems of which most have active bounds."""
    generator = np.random.default_rng(size)
    root = generator.normal(size=(count, size, size))
    hessian = root @ root.mT + 0.1 * np.eye(size)
    gradient = generator.normal(size=(count, size)) * 3.0
    low = -generator.uniform(0.0, 1.0, (count, size)) - 0.01
    return hessian, gradient, low, low + generator.uniform(0.02, 2.0, (count, size))


def by_enumeration(hessian: Array, gradient: Array, low: Array, high: Array) -> Array:
    """The least value over the minima of all sets of fixed components that are within the bounds."""
    size, best, least = len(gradient), low, float("inf")
    for choice in itertools.product((0, 1, 2), repeat=size):
        fixed = [index for index in range(size) if choice[index] < 2]
        free = [index for index in range(size) if choice[index] == 2]
        z = np.where(np.array(choice) == 0, low, high)
        right = -gradient[free] - hessian[np.ix_(free, fixed)] @ z[fixed]
        z[free] = np.linalg.solve(hessian[np.ix_(free, free)], right)
        value = float(0.5 * z @ hessian @ z + gradient @ z)
        if (z >= low).all() and (z <= high).all() and value < least:
            best, least = z, value
    return best


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_no_set_of_active_bounds_has_a_smaller_minimum(size: int) -> None:
    given = problems(size)
    found = box_minimum(*given)
    expected = np.array([by_enumeration(*row) for row in zip(*given, strict=True)])
    # condition numbers up to some thousand, times rounding
    np.testing.assert_allclose(found, expected, atol=1e-11)
    active = (found == given[2]) | (found == given[3])
    assert 0.2 < active.mean() < 0.9


@pytest.mark.parametrize("size", [1, 2, 3, 4])
def test_conditions_of_optimality_hold(size: int) -> None:
    hessian, gradient, low, high = problems(size)
    z = box_minimum(hessian, gradient, low, high)
    slope = gradient + (hessian @ z[..., None])[..., 0]
    scale = np.abs(hessian).sum(axis=(1, 2))[:, None]
    assert ((z >= low) & (z <= high)).all()
    # rounding of the eliminated components, relative to the entries of the Hessian matrix
    assert (np.abs(slope) <= 1e-11 * scale)[(z > low) & (z < high)].all()
    assert (slope >= -1e-11 * scale)[z == low].all()
    assert (slope <= 1e-11 * scale)[z == high].all()


def test_leading_dimensions_change_no_bit() -> None:
    hessian, gradient, low, high = problems(3, 12)
    together = box_minimum(*(part.reshape(3, 4, *part.shape[1:]) for part in (hessian, gradient, low, high)))
    alone = [box_minimum(*row) for row in zip(hessian, gradient, low, high, strict=True)]
    np.testing.assert_array_equal(together.reshape(12, 3), alone)
