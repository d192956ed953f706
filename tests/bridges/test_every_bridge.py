"""What holds for the bridge of every library, one after the other; skipped where a library is not installed."""

import subprocess
import sys
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

import sdaeverify
from bridges.equations import PATHS, H, curved, drawn, shifted
from facade import (
    BAOAB,
    QUICSORT,
    SRA1,
    EulerMaruyama,
    Heun,
    Milstein,
    angle_pendulum,
    gbm,
    harmonic_langevin,
    hyperbolic_pair,
    noncommuting,
    ou,
    spiral,
)
from sdaeverify import SDE, Increment, ParameterError
from sdaeverify_bridges.ase import ASE, CLAIMS
from sdaeverify_bridges.diffrax import LANGEVIN, ORDERS, Diffrax, DiffraxLangevin
from sdaeverify_bridges.kit import stratonovich_drift
from sdaeverify_bridges.mici import Mici
from sdaeverify_bridges.qutip import ORDERS as METHODS
from sdaeverify_bridges.qutip import QuTiP
from sdaeverify_bridges.sdeint import ORDERS as ALGORITHMS
from sdaeverify_bridges.sdeint import SDEInt
from sdaeverify_bridges.tinydiffeq import TinyDiffEq, TinyDiffEqSDAE
from sdaeverify_bridges.torchsde import ITO, STRATONOVICH, TorchSDEIto, TorchSDEStratonovich

pytestmark = pytest.mark.filterwarnings("default:os.fork:RuntimeWarning")


def skip_without(scheme):
    """Skip where the library of a bridge is not installed."""
    pytest.importorskip(scheme.claimant, reason=f"needs the extra: pip install .[{scheme.claimant}]")


@pytest.mark.parametrize(
    ("theirs", "ours", "families"),
    [
        (ASE("LangevinBAOAB"), BAOAB(), (angle_pendulum, harmonic_langevin)),
        (Diffrax("Euler"), EulerMaruyama(), (gbm, noncommuting, angle_pendulum)),
        (Diffrax("ItoMilstein"), Milstein(), (curved,)),
        (Diffrax("Heun"), Heun(), (curved, noncommuting)),
        (Diffrax("SRA1"), SRA1(), (ou, angle_pendulum)),
        (DiffraxLangevin("QUICSORT"), QUICSORT(), (angle_pendulum,)),
        (QuTiP("euler"), EulerMaruyama(), (gbm, noncommuting, harmonic_langevin)),
        (QuTiP("milstein"), Milstein(), (gbm, ou)),
        (SDEInt("itoEuler"), EulerMaruyama(), (gbm, noncommuting, angle_pendulum)),
        (SDEInt("stratHeun"), Heun(), (curved, noncommuting)),
        (TinyDiffEq("EulerMaruyama"), EulerMaruyama(), (gbm, hyperbolic_pair)),
        (TinyDiffEq("Milstein"), Milstein(), (gbm,)),
        (TinyDiffEq("SRA1"), SRA1(), (ou,)),
        (TorchSDEIto("euler"), EulerMaruyama(), (gbm, noncommuting)),
        (TorchSDEIto("milstein"), Milstein(), (curved,)),
        (TorchSDEIto("srk"), SRA1(), (ou, angle_pendulum)),
        (TorchSDEStratonovich("heun"), Heun(), (curved, noncommuting, spiral)),
    ],
    ids=lambda value: getattr(value, "label", ""),
)
def test_our_schemes_agree_to_rounding(theirs, ours, families):
    """On the same noise a library makes the step that ours makes, whoever takes the derivatives."""
    skip_without(theirs)
    for family in families:
        problem = family()
        seen = problem if isinstance(problem, theirs.forms) else problem.view(SDE)
        x, noise = shifted(seen), drawn(seen, H, PATHS)._replace(K=0.01 * np.cos(np.arange(PATHS))[None])
        found, expected = (scheme.step(seen, x, 0.5, H, noise).state for scheme in (theirs, ours))
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=4.0 * np.finfo(float).eps * np.abs(expected).max())


BITWISE = [
    *((ASE(name), angle_pendulum()) for name in CLAIMS),
    *((Diffrax(name), ou()) for name in ORDERS),
    *((QuTiP(name), ou()) for name in METHODS),
    *((TorchSDEIto(name), ou()) for name in ITO),
    *((TorchSDEStratonovich(name), ou()) for name in STRATONOVICH),
]


@pytest.mark.parametrize(("scheme", "problem"), BITWISE, ids=lambda value: getattr(value, "label", ""))
def test_paths_do_not_see_each_other(scheme, problem):
    """A path among others is the same to the last bit as that path alone."""
    skip_without(scheme)
    noise, state = drawn(problem, H, PATHS), scheme.enter(problem, shifted(problem), 0.5, H)
    alone = Increment(noise.dW[:, 4:5], noise.H[:, 4:5])

    found = scheme.step(problem, state, 0.5, H, noise).state[:, 4:5]
    np.testing.assert_array_equal(scheme.step(problem, state[:, 4:5], 0.5, H, alone).state, found)


@pytest.mark.parametrize(
    ("scheme", "arguments", "message"),
    [
        (ASE, ("Andersen",), "integrator must be one of Langevin, LangevinBAOAB, got 'Andersen'"),
        (Diffrax, ("Dopri5",), f"must be one of {', '.join(ORDERS)}, got 'Dopri5'"),
        (DiffraxLangevin, ("Dopri5",), f"must be one of {', '.join(LANGEVIN)}, got 'Dopri5'"),
        (Mici, (0,), "inner must be at least 1, got 0"),
        (QuTiP, ("rouchon",), r"method must be one of euler, .*, got 'rouchon'"),
        (SDEInt, ("stratKP2iS",), f"must be one of {', '.join(ALGORITHMS)}"),
        (SDEInt, ("itoEuler", True), "areas are for itoSRI2 and strat"),
        (TinyDiffEqSDAE, ("Milstein",), "solver must be one of EulerMaruyama, got 'Milstein'"),
        (TorchSDEIto, ("heun",), "method must be one of euler, milstein, srk, got 'heun'"),
        (TorchSDEIto, ("euler", True), "option of milstein"),
    ],
)
def test_what_a_library_has_not_is_refused(scheme, arguments, message):
    """A method that cannot be given a step at a time, or an option of another method, is refused."""
    with pytest.raises(ParameterError, match=message):
        scheme(*arguments)


class LouderDiffrax(Diffrax):
    """dW is given to the solver with a factor of 1.1."""

    name: ClassVar[str] = "diffrax-louder"

    def compiled(self, problem):
        right = super().compiled(problem)
        return lambda x, t, h, dW: right(x, t, h, 1.1 * dW)


class MistakenDiffrax(Diffrax):
    """A Stratonovich solver is given the drift of the Ito equation."""

    name: ClassVar[str] = "diffrax-mistaken"

    @property
    def stratonovich(self):
        return False


class LouderSDEInt(SDEInt):
    """dW is given to the algorithm with a factor of 1.1."""

    name: ClassVar[str] = "sdeint-louder"

    def compiled(self, problem):
        right = super().compiled(problem)
        return lambda x, t, h, dW: right(x, t, h, 1.1 * dW)


class MistakenSDEInt(SDEInt):
    """An algorithm for Ito's equation is given the drift of the Stratonovich equation."""

    name: ClassVar[str] = "sdeint-mistaken"

    def compiled(self, problem):
        return super().compiled(replace(problem, drift=lambda t, x: stratonovich_drift(problem, t, x)))


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        (LouderDiffrax("Euler"), Diffrax("Euler")),
        (MistakenDiffrax("Heun"), Diffrax("Heun")),
        (LouderSDEInt("itoSRI2"), SDEInt("itoSRI2")),
        (MistakenSDEInt("itoSRI2"), SDEInt("itoSRI2")),
    ],
    ids=lambda scheme: scheme.label,
)
def test_wrong_bridge_is_refuted(wrong, right):
    """A bridge that hands over the wrong noise or the wrong calculus is refuted, not the library's solver."""
    skip_without(right)
    found = sdaeverify.verify([wrong, right], [gbm], "strong", paths=512, levels=4, jobs=1).verdicts

    by_scheme = found.groupby("scheme")["verdict"].agg(set)
    assert by_scheme[wrong.label] == {"refuted"}
    assert "refuted" not in by_scheme[right.label]


@pytest.mark.parametrize("library", ["torchsde", "diffrax", "tinydiffeq"])
def test_listing_does_not_load_the_library(library):
    """Registering the schemes of a library that takes seconds to load takes none."""
    program = f"import sys, sdaeverify_bridges.{library} as plugin; print({{'torch', 'jax'}} & set(sys.modules))"

    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "set()"
