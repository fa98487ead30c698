"""Gains of adaptive control of the arm for questions other than those of the tuned gains: a score."""

from typing import Any

SOFT: dict[str, Any] = {
    "reference_gain": 56.0,
    "damping_gain": [9.85, 43.4, 0.442],
    "adaptation_gain": [1.09, 24.0, 0.12, 0.096, 2.4e-3, 1e-3, 3e-4, 3e-3, 3e-5, 1.5e-4, 1.5e-3, 1.5e-5],
}
"""Softer than the tuned gains and with faster adaptation."""
