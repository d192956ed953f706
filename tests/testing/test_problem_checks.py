"""Every check of a problem is seen to fail on a problem with that one fault."""

import dataclasses

import numpy as np
import pytest

from facade import ProblemSpec, circle, fibre_clamped, gbm, gbm_algebraic, ou, pendulum
from sdaeverify import (
    SDE,
    ConstrainedLangevin,
    ConstraintGeometry,
    Control,
    DenseJacobian,
    HolonomicSDAE,
    InvariantMean,
    Langevin,
    Moment,
    Partials,
    in_matrix,
    on_request,
)
from sdaeverify.testing import check_problem, checks
from testing.asking import of_problem

NAMES = [check.name for check in checks("problem")]
# An error that the checks where a problem is made let pass.
SLIGHT = 1.0 + 1e-8


def named(build, text="A planted fault."):
    """Return a problem function that builds this."""

    def planted():
        return build()

    planted.__doc__ = text
    return planted


def changed(family, **change):
    """Return a problem function that builds a shipped problem with some fields changed."""
    return named(lambda: dataclasses.replace(family(), **change))


def solved(family, **change):
    """Return a problem function whose solution on a path is changed."""
    problem = family()
    truths = [truth for truth in problem.truths if truth is not problem.pathwise]
    return changed(family, truths=(dataclasses.replace(problem.pathwise, **change), *truths))


def expecting(family, observable, value):
    """Return a problem function that knows this of an observable, and no solution."""
    return changed(family, truths=(Moment(observable=observable, value=value, source="planted"),))


def demanding(scale):
    """Return a function whose parameter has no default."""
    return gbm(scale)


@in_matrix({"N": 2}, {"N": 1})
def marked(N: int = 3):
    """Hang, with a row in the matrix that cannot be built."""
    return fibre_clamped(N=N)


def silent():
    return gbm()


def mean(t):
    return float(np.exp(0.5 * t))


def on_the_circle(**change):
    """Return Langevin dynamics near or on the unit circle, changed."""
    fields = {
        "drift": lambda x: -x,
        "strength": 0.5,
        "eps": 0.0,
        "constraint": lambda x: 0.5 * (x[0] * x[0] + x[1] * x[1] - 1.0)[None],
        "start": [0.6, 0.8],
        "horizon": 0.5,
        "source": "planted",
    }
    return named(lambda: ConstrainedLangevin(**{**fields, **change}))


class WrongGradient(ConstraintGeometry):
    """One whose closed form of grad ln det G is slightly off."""

    @property
    def fixman(self):
        return SLIGHT**100 * ConstraintGeometry(self.problem, self.x).fixman


class Doubling(Langevin):
    """One whose first-order system has too much friction."""

    def ito(self):
        return dataclasses.replace(self, friction=2.0 * self.friction).as_it_is()

    def as_it_is(self):
        return super().ito()

    def view(self, form):
        return self.ito() if form is SDE else super().view(form)


class Unpushed(HolonomicSDAE):
    """One whose multiplier is a little too large for what it does to the velocity."""

    def ito(self):
        full = super().ito()
        factors = np.array([1.0, 1.0, 1.0, 1.0, SLIGHT])[:, None]
        return dataclasses.replace(full, drift=lambda t, x: factors * full.drift(t, x), truths=())


def unpushed():
    """Return the pendulum with that multiplier."""
    fields = {field.name: getattr(pendulum(), field.name) for field in dataclasses.fields(pendulum())}
    return Unpushed(**fields)


def doubled():
    """Return damped motion seen as one with twice the friction."""
    return Doubling(
        force=lambda q: -q, friction=0.5, strength=0.7, position=[1.0], momentum=[0.0], horizon=1.0, source="planted"
    )


def shifted(family, **change):
    """Return a problem function with a chart that is changed."""
    return changed(family, chart=dataclasses.replace(family().chart, **change))


def read_too_far(x):
    return pendulum().chart.read(x) + 1e-6


def matrices(of_x):
    return lambda t, x, v, y: Partials(of_x + 0.0 * x[None], 0.0 * x[None], 1.0 + 0.0 * x[None])


def two_noises(diffusion):
    """Return the equation dx = -x dt + B dW in the plane as diagonal noise."""
    return named(
        lambda: SDE(
            drift=lambda t, x: -x,
            diffusion=diffusion,
            start=[1.0, 2.0],
            noise_dim=2,
            horizon=1.0,
            source="planted",
            traits=frozenset({"diagonal-noise"}),
        )
    )


SWAPPED = Control(measure="strong", order=1.0, positive="euler-maruyama", negative="milstein")
ABSENT = Control(measure="strong", order=1.0, positive="milstein", negative="no-such-scheme")
R_0 = float(pendulum().position[0])

FAULTS = {
    "declaration": (demanding, "has no default"),
    "builds": (named(lambda: dataclasses.replace(gbm(), start=[np.nan])), "vector of finite numbers"),
    "label": (ProblemSpec("gbm", gbm, (("a", 0.5),)), "a different problem"),
    "pickle": (changed(gbm), "pickle"),
    "docstring": (silent, "no docstring"),
    "source": (changed(gbm, truths=(Moment(observable="x", value=mean, source=" "),)), "a Moment"),
    "in-matrix": (marked, "N must be a whole number from 2"),
    "relaxation": (changed(gbm, relaxation_time=1.0), "neither an invariant mean nor a moment equation"),
    "consistent-start": (changed(circle, start=circle().start * (1.0 + 1e-13), truths=()), "g at the start"),
    "observables": (changed(gbm, observables={"x": lambda t, s: np.ones(3)}, truths=()), "on 1 paths"),
    "path-by-path": (changed(gbm, drift=lambda t, x: x - x.mean()), "drift on one path"),
    "finite-in-time": (changed(gbm, drift=lambda t, x: x / (t < 0.7)), "drift is not finite at time 0.7"),
    "diffusion-product": (changed(gbm, diffusion_product=lambda t, x, w: 0.6 * w * x ** (x > 1.0)), "is off by"),
    "diffusion-derivative": (changed(gbm, diffusion_derivative=lambda t, x, y: SLIGHT * 0.6 * y[:, None]), "DB(x) y"),
    "constraint-jacobian": (changed(pendulum, jacobian=lambda r: -SLIGHT * r[None]), "the Jacobian"),
    "constraint-curvature": (
        changed(pendulum, curvature=lambda r, y, z: -SLIGHT * (y * z).sum(axis=0)[None]),
        "the curvature",
    ),
    "constraint-second-derivatives": (on_the_circle(second=lambda x, A: SLIGHT * A[:, 0]), "the second derivative"),
    "constraint-linearisation": (
        changed(pendulum, linearisation=lambda r: DenseJacobian(-r[None] * (1.0 + 0.1 * (r[0] - R_0)))),
        "times disagrees",
    ),
    "force-derivatives": (
        changed(pendulum, force_derivatives=lambda t, r, v: (1e-8 * np.eye(2)[..., None],) * 2),
        "force_derivatives is",
    ),
    "delay-derivatives": (changed(gbm_algebraic, drift_partials=matrices(-SLIGHT)), "the derivatives of drift"),
    "algebraic-solution": (
        changed(gbm_algebraic, solved=lambda t, x, v: 0.5 * x ** (1.0 + 1e-9)),
        "u at its solution y",
    ),
    "constraints-kept": (changed(circle, drift=lambda t, x: -0.4 * x), "lacks a part of Ito's term"),
    "view-equals-form": (doubled, "first-order system is"),
    "traits": (two_noises(lambda t, x: x[::-1] * np.eye(2)[..., None]), "trait diagonal-noise is false"),
    "chart": (shifted(pendulum, read=read_too_far), "read(embed(z)) is"),
    "moments-start": (expecting(gbm, "x", lambda t: 1.0 + 1e-9 + t), "begins with 1,"),
    "moments-rate": (expecting(gbm, "x", lambda t: 1.0 + 0.5001 * t), "begins with the rate 0.5001"),
    "moments-settle": (
        changed(ou, truths=(*ou().truths, InvariantMean(observable="x", value=0.01, source="planted"))),
        "its invariant mean 0.01",
    ),
    "moments-simulated": (expecting(gbm, "x", lambda t: mean(t) + 0.3 * t * t), "Euler's x has the mean"),
    "solution-start": (solved(gbm, parts=lambda t, x: {"x": x, "z": x}), "the problem's components"),
    "solution-step": (solved(gbm, advance=lambda x, t, h, noise: np.multiply(x, 2.0, out=x)), "writes into"),
    "solution-still": (solved(gbm, advance=lambda x, t, h, noise: x + 1e-9), "a step of length 0"),
    "solution-simulated": (
        solved(gbm, advance=lambda x, t, h, noise: x * np.exp(0.5 * h + 0.6 * noise.dW)),
        "it falls like h^0.0",
    ),
    "solution-averaged": (
        solved(gbm, advance=lambda x, t, h, noise: x * np.exp(0.5 * h + 0.6 * noise.dW)),
        "the solution's x has the mean",
    ),
    "controls": (changed(gbm, controls=(SWAPPED,)), "the positive control euler-maruyama of strong order 1"),
}
MORE = [
    ("builds", named(dict), "expected a problem"),
    ("view-equals-form", unpushed, "grad g dmu) is off"),
    ("view-equals-form", on_the_circle(eps=0.1, geometry=WrongGradient), "the drift of the penalised SDE"),
    ("constraints-kept", on_the_circle(second=lambda x, A: 1.0000001 * A[:, 0]), "lacks a part of Ito's term"),
    ("solution-simulated", solved(gbm, advance=lambda x, t, h, n: x * np.exp(0.32 * h + 0.63 * n.dW)), "it falls"),
    ("controls", changed(gbm, controls=(ABSENT,)), "unknown scheme"),
    ("relaxation", changed(ou, relaxation_time=np.inf), "no relaxation time"),
]


def test_every_check_of_a_problem_has_a_fault():
    """Nothing is asked that was never seen to fail."""
    assert list(FAULTS) == NAMES


@pytest.mark.parametrize(("check", "problem", "text"), [*((c, *pair) for c, pair in FAULTS.items()), *MORE])
def test_a_fault_is_found_by_its_check(check, problem, text):
    """The check of this fault fails, and says what is wrong in one line."""
    outcome = of_problem(problem, check)

    assert outcome["status"] == "failed"
    assert text in outcome["reason"]
    assert "\n" not in outcome["reason"]


@pytest.mark.parametrize("eps", [0.0, 0.1])
@pytest.mark.parametrize("check", ["constraint-second-derivatives", "constraints-kept", "view-equals-form"])
def test_langevin_dynamics_in_which_faults_are_planted_are_sound(check, eps):
    """Without fault, the penalised and the constrained dynamics pass."""
    outcome = of_problem(on_the_circle(eps=eps), check)

    assert outcome["status"] == ("skipped" if eps and check == "constraints-kept" else "passed")


def stiff_fibre():
    """Build a fibre with the parameters of Lindner et al. (2018), Fig. 4.2."""
    return fibre_clamped(alpha=0.4, horizon=0.25)


def wrongly_bent_fibre():
    """Build the same with a wrong curvature."""
    problem = stiff_fibre()
    return dataclasses.replace(problem, curvature=lambda r, y, z: SLIGHT * problem.d2g(r, y, z))


@pytest.mark.parametrize("check", ["constraint-curvature", "constraints-kept"])
def test_a_stiff_problem_is_asked_where_its_solutions_are(check):
    """An explicit run went to states of size 1e5 and more, where rounding was taken for a fault."""
    outcome = of_problem(stiff_fibre, check)

    assert outcome["status"] == "passed", outcome["reason"]
    assert of_problem(wrongly_bent_fibre, "constraint-curvature")["status"] == "failed"


def test_a_problem_that_cannot_be_built_is_asked_nothing_else():
    """All but what is read from the function is skipped, with the reason."""
    rows = check_problem(FAULTS["builds"][0])
    asked = [row["check"] for row in rows if row["status"] != "skipped"]

    assert asked == ["declaration", "builds", "docstring"]
    assert all("cannot be built" in row["reason"] for row in rows if row["status"] == "skipped")


def test_the_mark_of_a_long_problem_is_no_fault():
    """What is put on request passes."""
    assert of_problem(on_request(named(gbm)), "in-matrix")["status"] == "passed"
