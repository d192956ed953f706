"""What one compiled step of another library costs beside the native step of the same formula, on one core."""

import numpy as np
import pytest

from benchmarks.pairs import run_pairs
from facade import EulerMaruyama, Heun, spiral
from sdaeverify import Increment
from sdaeverify_bridges.diffrax import Diffrax
from sdaeverify_bridges.sdeint import SDEInt
from sdaeverify_bridges.torchsde import TorchSDEIto, TorchSDEStratonovich

pytestmark = [pytest.mark.benchmark, pytest.mark.filterwarnings("ignore")]

PATHS, H = 4096, 2.0**-6
PAIRS = {
    "diffrax Euler": ("diffrax", Diffrax("Euler"), EulerMaruyama()),
    "diffrax Heun": ("diffrax", Diffrax("Heun"), Heun()),
    "torchsde euler": ("torchsde", TorchSDEIto("euler"), EulerMaruyama()),
    "torchsde heun": ("torchsde", TorchSDEStratonovich("heun"), Heun()),
    "sdeint itoEuler": ("sdeint", SDEInt("itoEuler"), EulerMaruyama()),
    "sdeint stratHeun": ("sdeint", SDEInt("stratHeun"), Heun()),
}


@pytest.mark.parametrize("pair", PAIRS)
def test_bridged_step_against_the_native_one(pair, benchmark, report, one_core):
    """Both make the same step; the bridge's compilation is not counted."""
    library, theirs, ours = PAIRS[pair]
    pytest.importorskip(library, reason=f"needs the extra: pip install .[{library}]")
    problem, rng = spiral(), np.random.default_rng(1)
    x, noise = problem.initial(PATHS), Increment(np.sqrt(H) * rng.standard_normal((1, PATHS)), None)
    steps = [scheme.prepare(problem, H) for scheme in (theirs, ours)]

    np.testing.assert_allclose(*(step(x, 0.0, noise).state for step in steps), rtol=1e-12)
    ratio = run_pairs(benchmark, *(lambda step=step: step(x, 0.0, noise) for step in steps), rounds=50).cost
    report(f"step of {pair} on {PATHS} paths / native", ratio, "at most 20")
