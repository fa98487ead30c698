"""Traced functions of rows of numbers."""

from typing import Any

import numpy as np

from prp_gym.symbolic.function import trace


def test_rows_have_the_bits_of_each_evaluated_alone() -> None:
    def formula(x: Any, y: Any) -> dict[str, Any]:
        chosen = np.where(x[..., :1] > y, np.exp(x[..., 1:2]), np.arctan2(x[..., 2:], y) % 0.3)
        return {"chosen": chosen, "single": x.astype(np.float32), "constant": np.zeros_like(y) + 0.5}

    function = trace("formula", formula, {"x": (3,), "y": (1,)})
    generator = np.random.default_rng(1)
    x, y = generator.normal(size=(4, 5, 3)), generator.normal(size=(4, 5, 1))
    found = function.evaluate_rows({"x": x, "y": y})
    assert 0.1 < (x[..., :1] > y).mean() < 0.9
    for index in np.ndindex(4, 5):
        alone = function.evaluate({"x": x[index], "y": y[index]})
        for name, values in alone.items():
            np.testing.assert_array_equal(found[name][index], values)
