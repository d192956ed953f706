"""The conformance kit: named checks for schemes and problems, for whoever writes them.

::

    from sdaeverify.testing import check_problem, check_scheme
    from sdaeverify.testing import parametrize_with_benchmarks, parametrize_with_checks
    from sdaeverify.testing import parametrize_with_claims, parametrize_with_hunts

    failed = [row for row in check_scheme(MyScheme()) if row["status"] == "failed"]

    @parametrize_with_checks([MyScheme(), my_problem])
    def test_conformance(subject, check):
        check(subject)

    @parametrize_with_claims([MyScheme()])
    def test_claims(subject, check):
        check(subject)

    @parametrize_with_hunts([MyScheme()])
    def test_no_counterexample(subject, check):
        check(subject)

    @parametrize_with_benchmarks([MyScheme()])
    def test_speed(benchmark, timing):
        timing(benchmark)

`check_scheme` and `check_problem` need no pytest and raise nothing for a check that fails. `checks` returns the
tables below.

A scheme is asked, the behaviour of its steps on each problem by itself:

declaration (api)
    Expect a frozen dataclass with a name, a form, claims, and parameters that a label can show.
label (api)
    Expect the label to make the scheme again: the command that reproduces a result has nothing else.
pickle (api)
    Expect an equal value after pickling: that is how worker processes get it.
frozen (api)
    Expect a value that nobody can change: a step that changes its scheme depends on the order of calls.
docstring (api)
    Expect a docstring of the class: a list of schemes shows its first line.
source (api)
    Expect a source, of the scheme or of its claims, which always have one: where it is from.
claims (api)
    Expect claims that can be verified: each names a known measure and known traits.
exact-on-trivial-equations (behaviour)
    Expect exactness on dx = 0, dx = c dt and dx = S dW, but for a part that vanishes with h.
inputs-untouched (behaviour)
    Expect a step to leave state and noise as they were, read-only or not: other schemes read the noise, too.
state-like-its-own (behaviour)
    Expect a step to return a state like the one it was given, and flags, outputs and costs with a value a path.
any-number-of-paths (behaviour)
    Expect a step to take one path, and three, from the scheme's own start.
finite (behaviour)
    Expect a step from finite states to be finite, unless it says that it failed.
same-call-same-bits (behaviour)
    Expect the same call to give the same bits, after other calls, many of them, and from a step prepared anew.
paths-in-any-order (behaviour)
    Expect paths in another order to go where they went: their place in the batch is no part of the noise.
paths-alone (behaviour)
    Expect a path to go the same way alone and in any batch: paths that see each other are not independent.
any-number-of-steps (behaviour)
    Expect steps of a run of 10 and of 50 steps to be like those of runs of 2^k steps, which all levels have.
declared-noise-only (behaviour)
    Expect a step to use no noise but what it declares: the rest may not be drawn, or be anything.
equation-alone (behaviour)
    Expect a step to depend on the equation alone: not on a problem's source, observables or truths.
noise-is-used (behaviour)
    Expect a step to use the increment of the Brownian motion wherever the equation has noise.
own-memory (behaviour)
    Expect the new state to share no memory with the noise, which is drawn afresh.
state-is-whole (behaviour)
    Expect all memory to be in the state: from a copy of it, a fresh copy of the scheme goes on alike.
claims-tested (behaviour)
    Expect each claim to hold on a registered problem, and its quantities to be measured there.

A problem is asked, what is not there being skipped:

declaration (api)
    Expect a function with a name, and with parameters whose defaults a label can show.
builds (api)
    Expect the function to return a problem that does not contradict itself.
label (api)
    Expect the label to make the problem again: the command that reproduces a result has nothing else.
pickle (api)
    Expect the function to be pickled by its name: that is how worker processes get it.
docstring (api)
    Expect a docstring: a list of problems shows its first line.
source (api)
    Expect sources of the problem and of each truth, and units.
in-matrix (api)
    Expect a problem for each row that its function has in the matrix, and the schemes and measures named there.
relaxation (api)
    Expect a relaxation time exactly where an invariant law is known: chains are run as long as it says.
consistent-start (behaviour)
    Expect all constraints to hold at the start, the hidden ones and 0 = u too: paths begin there.
observables (behaviour)
    Expect each observable to be one finite number a path, on one path and on three.
path-by-path (behaviour)
    Expect drift and diffusion of a path not to depend on the paths beside it.
finite-in-time (behaviour)
    Expect drift and diffusion to be finite at the start's state at times over the horizon, its end left out.
diffusion-product (behaviour)
    Expect the given product of the diffusion with a vector to be that of the matrix, wherever a path goes.
diffusion-derivative (behaviour)
    Expect DB(x) y, given or by complex step, to be the derivative of the diffusion: Milstein's scheme needs it.
constraint-jacobian (behaviour)
    Expect Dg, given or by complex step, to be the derivative of the constraint, on the manifold and beside it.
constraint-curvature (behaviour)
    Expect the curvature D^2 g(y, z) to be symmetric and the second derivative of the constraint.
constraint-second-derivatives (behaviour)
    Expect the second derivatives of the constraint of Langevin dynamics, and their traces, to be those of Dg.
constraint-linearisation (behaviour)
    Expect the linearised constraint that was given to do what its matrix does, wherever a path goes.
force-derivatives (behaviour)
    Expect the given derivatives of the force to be its own: implicit schemes solve with them.
delay-derivatives (behaviour)
    Expect the partial derivatives in x, v and y, given or by complex step, to be those of f and of u.
algebraic-solution (behaviour)
    Expect the algebraic components, solved for or given by `solved`, to solve 0 = u wherever x and v are.
constraints-kept (behaviour)
    Expect drift and diffusion of the SDE to keep the constraints: Dg B = 0, and Ito's condition on the drift.
view-equals-form (behaviour)
    Expect the SDE that a problem is seen as to be its own equation, put together here once more.
traits (behaviour)
    Expect every declared trait to be true: where one is false, claims are refuted that nobody made.
chart (behaviour)
    Expect a chart to read the coordinates it embeds, on the manifold, and to cover the start.
moments-start (truths)
    Expect each moment to begin with its observable at the start, and to be a finite number at every time.
moments-rate (truths)
    Expect each moment of an observable q to begin with the rate Dq f + (1/2) sum_j D^2 q(B_j, B_j).
moments-settle (truths)
    Expect moments to tend to the invariant means of the same observables.
moments-simulated (truths)
    Expect means of simulations to be the moments, within an interval of level 1e-6 in all and Euler's own bias.
solution-start (truths)
    Expect the solution to know components of the problem, and to have them right at time 0.
solution-step (truths)
    Expect a step of the solution to keep its shape and to leave its inputs alone, on one path and on three.
solution-still (truths)
    Expect a step of the solution without time and noise to change nothing.
solution-simulated (truths)
    Expect Euler's scheme on the same noise to tend to the solution: the distance falls like h^0.3 or faster.
solution-averaged (truths)
    Expect means of the solution over 4096 paths to be the moments, within an interval of level 1e-6 in all.
controls (truths)
    Expect the positive control of each order to be verified, and the negative one to be refuted.
"""

from typing import TYPE_CHECKING

from .benchmarks import parametrize_with_benchmarks
from .check import LEVEL, Check
from .claims import parametrize_with_claims, parametrize_with_examinations
from .questions import check_problem, check_scheme, parametrize_with_checks
from .table import checks

if TYPE_CHECKING:
    from .hunts import parametrize_with_hunts

__all__ = [
    "LEVEL",
    "Check",
    "check_problem",
    "check_scheme",
    "checks",
    "parametrize_with_benchmarks",
    "parametrize_with_checks",
    "parametrize_with_claims",
    "parametrize_with_examinations",
    "parametrize_with_hunts",
]


def __getattr__(name: str) -> object:
    # The hunt is no part of the core: the kit does without where it is left out.
    if name != "parametrize_with_hunts":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from .hunts import parametrize_with_hunts as found  # noqa: PLC0415

    return found
