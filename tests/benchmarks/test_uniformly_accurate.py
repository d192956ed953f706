"""The time of steps that solve for a multiplier of constrained Langevin dynamics, in units of drawing their noise."""

from functools import partial

import numpy as np
import pytest

from benchmarks.pairs import run_pairs
from facade import ConstrainedEuler, UniformlyAccurate, orthogonal_group, torus
from sdaeverify import Increment
from sdaeverify.studying import Source

pytestmark = pytest.mark.benchmark

WARM, SIZES, PAIRS = 10, (500, 2048, 4096), 101
GROUP = partial(orthogonal_group, stiffness=100.0, horizon=1.0)
# Parameters of sections 4.1 and 4.2 of Laurent (2022).
CASES = {
    "torus": (UniformlyAccurate(), torus(0.01), 10.0 / 2**10, 40),
    "O(3)": (ConstrainedEuler(), GROUP(0.0, 3), 2.0**-7, 30),
    "O(5)": (UniformlyAccurate(), GROUP(0.005, 5), 2.0**-7, 80),
}


@pytest.mark.parametrize("paths", SIZES)
@pytest.mark.parametrize("name", CASES)
def test_a_step_with_a_multiplier_against_drawing_its_normals(name, paths, benchmark, report, one_core):
    """A step costs some tens of draws of its normals a path, Newton's method included."""
    scheme, problem, h, most = CASES[name]
    stream = Source(1, "benchmark", 0, paths).stream("brownian", 0)
    shape = (problem.noise_dim, paths)
    dW = np.sqrt(h) * stream.standard_normal((WARM + 1, *shape))
    state, stepper = problem.initial(paths), scheme.prepare(problem, h)
    for n in range(WARM):
        state = stepper(state, n * h, Increment(dW[n], None)).state
    last = partial(stepper, state, WARM * h, Increment(dW[-1], None))

    pairs = run_pairs(benchmark, last, lambda: stream.standard_normal(shape), PAIRS)
    # Minima: who else uses the machine interrupts a step more often than a draw, which is much shorter.
    ratio = min(pairs.ours) / min(pairs.other)
    report(f"{scheme.label} on {name}, {paths} paths, step / draw of normals", ratio, f"at most {most}")
