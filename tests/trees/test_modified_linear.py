"""The leading weak error on linear equations follows from modified equations, and is what moments show."""

import csv
import runpy
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
import scipy

from facade import (
    classes_of,
    gbm,
    leading_error,
    linear_equation,
    load_registry,
    modified_equation,
    moment_errors,
    observable_errors,
    order_of,
    ou,
    quadratic_form,
)
from sdaeverify import SDE, Increment, Settings, Step
from sdaeverify.arrays import Array
from sdaeverify_schemes.delays.stochastic_theta import StochasticTheta
from sdaeverify_schemes.euler_maruyama import EulerMaruyama
from sdaeverify_schemes.heun import Heun, HeunAdditive
from sdaeverify_schemes.milstein import Milstein
from sdaeverify_schemes.platen_weak_2 import PlatenWeak2
from sdaeverify_schemes.sra1 import SRA1

PROGRAM = Path(__file__).parents[2] / "reports" / "constants" / "leading_moments.py"
leading_moments = runpy.run_path(str(PROGRAM))["leading_moments"]
CELLS = [
    (EulerMaruyama(), "ou", "additive"),
    (HeunAdditive(), "ou", "additive"),
    (SRA1(), "ou", "additive"),
    (StochasticTheta(), "ou", "additive"),
    (EulerMaruyama(), "gbm", "scalar"),
    (Milstein(), "gbm", "scalar"),
    (Heun(), "gbm", "scalar"),
    (PlatenWeak2(), "gbm", "scalar"),
    (EulerMaruyama(), "three-motions", "general"),
    (Heun(), "three-motions", "general"),
]


def predicted(scheme, view, kind):
    """Return the coefficients of all moments at T, and the order, by the modified equation."""
    of = modified_equation(scheme, classes_of(scheme)[kind], view.noise_dim)
    ito = view.ito()
    return of.order, leading_moments(of, linear_equation(ito), ito.initial(1)[:, 0], view.horizon)


def shown(scheme, view, name):
    """Return the leading error of an observable by moments at T."""
    errors = observable_errors(moment_errors(scheme, view, Settings().steps), quadratic_form(view, name))
    return leading_error(*errors[:3], order_of(*errors).order)


def linear_problem(name):
    """Return a shipped problem."""
    return load_registry(environ={}).things("sdaeverify_problems")[name]()


@pytest.mark.sweep
@pytest.mark.parametrize(("scheme", "problem", "kind"), CELLS, ids=lambda each: getattr(each, "label", each))
def test_moments_show_what_is_predicted(scheme, problem, kind):
    """On each quadratic observable whose leading term does not vanish; order and constant agree."""
    view = linear_problem(problem)
    order, moments = predicted(scheme, view, kind)
    compared = 0
    for name in view.observables:
        form = quadratic_form(view, name)
        if form is None:
            continue
        constant, found = float(form.of_moments(moments[:-1, -1], moments[:-1, :-1])), shown(scheme, view, name)
        assert found.power == order
        assert abs(constant - found.value) <= found.known + 1e-9 * abs(constant)
        compared += 1
    assert compared >= 2


def test_euler_maruyama_on_the_ornstein_uhlenbeck_process():
    """E x_n = (1 - h)^n is off by -h e^-1/2 at T = 1, by hand."""
    order, moments = predicted(EulerMaruyama(), ou(), "additive")

    assert order == 1.0
    assert moments[0, 1] == pytest.approx(-0.5 * np.exp(-1.0), rel=1e-12)


@dataclass(frozen=True)
class Shifted(EulerMaruyama):
    """Euler-Maruyama with the drift at x + c h f, of the same order and with another constant."""

    c: float = 0.05

    name: ClassVar[str] = "shifted"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        ahead = state + self.c * h * problem.drift(t, state)
        return Step(state + h * problem.drift(t, ahead) + problem.diffused(t, state, noise.dW))


def test_another_constant_is_told_from_the_right_one():
    """A term that changes the constant by a tenth is seen by both ways, and one does not pass for the other."""
    view = gbm()
    right, other = (predicted(scheme, view, "scalar")[1][0, 1] for scheme in (EulerMaruyama(), Shifted()))
    found = shown(Shifted(), view, "x")

    assert abs(other - found.value) <= found.known
    assert abs(right - found.value) > 0.05 * abs(right)


def test_the_committed_table():
    """Predictions are what moments show, and no paths are beyond what chance explains, of all cells together."""
    file = Path(__file__).parents[2] / "reports" / "constants" / "constants.csv"
    with file.open(newline="") as table:
        rows = [*csv.DictReader(table)]
    both = [(float(row["modified"]), float(row["constant"])) for row in rows if row["modified"]]
    z = [abs(float(row["z"])) for row in rows if row["z"]]

    assert len(both) > 100
    assert all(one == pytest.approx(other, rel=1e-3) for one, other in both)
    assert len(z) > 300
    # Bonferroni: one of so many tests at 0.01 together, Student's t with 19 degrees of freedom.
    assert max(z) <= scipy.special.stdtrit(19, 1.0 - 0.005 / len(z))
