"""Results do not depend on the kind of CPU: neither on OpenBLAS's kernels nor on NumPy's instruction sets."""

import functools
import json
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
KERNELS = {"Prescott": "Katmai", "Haswell": "Haswell"}
"""Kernels by the name that selects them, and by the name that OpenBLAS then reports."""

pytestmark = pytest.mark.skipif(platform.machine() != "x86_64", reason="names of kernels of x86-64 CPUs")


@functools.cache
def results(*variables: tuple[str, str]) -> dict[str, Any]:
    """What `tests.support.results_of_every_task` reports in a process with these environment variables."""
    command = [sys.executable, "-m", "tests.support.results_of_every_task"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **dict(variables)}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def with_kernel(name: str) -> dict[str, Any]:
    found = results(("OPENBLAS_CORETYPE", name))
    if found["kernel"] != KERNELS[name]:
        pytest.skip(f"this CPU or build of NumPy has no kernels of {name}, but {found['kernel']!r}")
    return found


@pytest.mark.parametrize("kernel", KERNELS)
def test_results_do_not_depend_on_the_kernels_of_openblas(kernel: str) -> None:
    assert with_kernel(kernel)["digests"] == results()["digests"]


def test_results_do_not_depend_on_the_instruction_set_of_numpy() -> None:
    here = results()
    if not here["extensions"]:
        pytest.skip("NumPy uses its baseline instruction set on this CPU")
    baseline = results(("NPY_DISABLE_CPU_FEATURES", " ".join(here["extensions"])))
    assert baseline["extensions"] == []
    assert baseline["digests"] == here["digests"]


@pytest.mark.parametrize("name", ["vecdot", "matmul"])
def test_sums_of_blas_do_depend_on_its_kernels(name: str) -> None:
    found = {with_kernel(kernel)["dependent"][name] for kernel in KERNELS}
    assert len(found) == len(KERNELS)
