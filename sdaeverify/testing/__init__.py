"""The conformance kit: named checks for the authors of schemes and problems.

::

    from sdaeverify.testing import check_problem, check_scheme
    from sdaeverify.testing import parametrize_with_benchmarks, parametrize_with_checks
    from sdaeverify.testing import parametrize_with_claims

    failed = [row for row in check_scheme(MyScheme()) if row["status"] == "failed"]

    @parametrize_with_checks([MyScheme(), my_problem])
    def test_conformance(subject, check):
        check(subject)

    @parametrize_with_claims([MyScheme()])
    def test_claims(subject, check):
        check(subject)

    @parametrize_with_benchmarks([MyScheme()])
    def test_speed(benchmark, timing):
        timing(benchmark)

`check_scheme` and `check_problem` do not need pytest, and report failed checks without raising. `checks` returns the
tables below.

Checks of a scheme; those of the behaviour of its steps are made on each problem separately:

declaration (api)
    Expect a frozen dataclass with a name, a form, claims, and parameters that a label can represent.
label (api)
    Expect the label to recreate the scheme, because commands that reproduce results contain only the label.
pickle (api)
    Expect an equal value after pickling, because worker processes receive a pickled copy.
frozen (api)
    Expect an immutable value: a step that changes its scheme depends on the order of calls.
docstring (api)
    Expect a docstring of the class, because lists of schemes show its first line.
source (api)
    Expect a source of the scheme, or a claim, which always has one.
claims (api)
    Expect claims that can be verified: each names a known measure and known traits.
exact-on-trivial-equations (behaviour)
    Expect exactness on dx = 0, dx = c dt and dx = S dW, except for a part that vanishes with h.
inputs-untouched (behaviour)
    Expect a step to leave state and noise as they were, read-only or not: other schemes read the noise, too.
state-like-its-own (behaviour)
    Expect a step to return a state like the one it was given, and flags, outputs and costs with a value a path.
any-number-of-paths (behaviour)
    Expect a step to accept one path, and three, from the scheme's start.
finite (behaviour)
    Expect a step from finite states to be finite, unless it is marked as failed.
same-call-same-bits (behaviour)
    Expect the same call to give the same bits, after other calls, many of them, and from a step prepared anew.
paths-in-any-order (behaviour)
    Expect the same results for paths in another order, because the place of a path in the batch must not matter.
paths-alone (behaviour)
    Expect a path to be the same alone and in any batch, because coupled paths are not independent.
any-number-of-steps (behaviour)
    Expect steps of runs of 10 and 50 steps to agree with those of runs of 2^k steps, used by all levels.
declared-noise-only (behaviour)
    Expect a step to use no noise but what it declares: the rest may not be drawn, or be anything.
equation-alone (behaviour)
    Expect a step to depend on the equation alone: not on a problem's source, observables or truths.
noise-is-used (behaviour)
    Expect a step to use the increment of the Brownian motion wherever the equation has noise.
own-memory (behaviour)
    Expect the new state to share no memory with the noise, which is drawn afresh.
state-is-whole (behaviour)
    Expect the state to hold all memory: a fresh copy of the scheme continues equally from a copy of it.
claims-tested (behaviour)
    Expect each claim to apply to a registered problem, and its quantities to be measured there.

Checks of a problem; checks of optional parts that it lacks are skipped:

declaration (api)
    Expect a function with a name, and with parameters whose defaults a label can represent.
builds (api)
    Expect the function to return a consistent problem.
label (api)
    Expect the label to recreate the problem, because commands that reproduce results contain only the label.
pickle (api)
    Expect the function to be pickled by name, because worker processes receive it that way.
docstring (api)
    Expect a docstring, because lists of problems show its first line.
source (api)
    Expect units, and sources of the problem and of each truth.
in-matrix (api)
    Expect each matrix entry of the function to build, and its named schemes and measures to exist.
relaxation (api)
    Expect a relaxation time if and only if an invariant law is known, because it sets the length of chains.
consistent-start (behaviour)
    Expect all constraints, hidden ones and 0 = u included, to hold at the start of paths.
observables (behaviour)
    Expect each observable to be one finite number per path, on one path and on three.
path-by-path (behaviour)
    Expect drift and diffusion of a path not to depend on other paths of the batch.
finite-in-time (behaviour)
    Expect drift and diffusion to be finite at the initial state at times over the horizon, excluding its end.
diffusion-product (behaviour)
    Expect the given product of the diffusion with a vector to equal that of the matrix along a run.
diffusion-derivative (behaviour)
    Expect DB(x) y, given or by complex step, to be the derivative of the diffusion, for Milstein's scheme.
constraint-jacobian (behaviour)
    Expect Dg, given or by complex step, to be the derivative of the constraint, on and off the manifold.
constraint-curvature (behaviour)
    Expect the curvature D^2 g(y, z) to be symmetric and the second derivative of the constraint.
constraint-second-derivatives (behaviour)
    Expect the second derivatives of the constraint of Langevin dynamics, and their traces, to be those of Dg.
constraint-linearisation (behaviour)
    Expect the given linearised constraint to act as its matrix does along a run.
force-derivatives (behaviour)
    Expect the given derivatives of the force to be correct, because implicit schemes solve with them.
delay-derivatives (behaviour)
    Expect the partial derivatives in x, v and y, given or by complex step, to be those of f and of u.
algebraic-solution (behaviour)
    Expect the algebraic components, solved for or given by `solved`, to solve 0 = u along a run.
constraints-kept (behaviour)
    Expect drift and diffusion of the SDE to keep the constraints: Dg B = 0, and Ito's condition on the drift.
view-equals-form (behaviour)
    Expect the SDE view of a problem to be its equation, assembled here independently.
traits (behaviour)
    Expect every declared trait to be true, because a false one leads to refutation of claims never made.
chart (behaviour)
    Expect a chart to invert its embedding, to satisfy the constraints, and to cover the start.
moments-start (truths)
    Expect each moment to equal its observable at the start, and to be a finite number at every time.
moments-rate (truths)
    Expect the initial rate of each moment of an observable q to be Dq f + (1/2) sum_j D^2 q(B_j, B_j).
moments-settle (truths)
    Expect moments to converge to the invariant means of the same observables.
moments-simulated (truths)
    Expect means of simulations to equal the moments, up to an interval of level 1e-6 in all and Euler's bias.
solution-start (truths)
    Expect the solution to have components of the problem, with the right values at time 0.
solution-step (truths)
    Expect a step of the solution to keep its shape and its inputs unchanged, on one path and on three.
solution-still (truths)
    Expect the solution to return its state to the bit after a step of length 0 with dW = 0.
solution-simulated (truths)
    Expect Euler's scheme on the same noise to converge to the solution: the distance falls at least like h^0.3.
solution-averaged (truths)
    Expect means of the solution over 4096 paths to equal the moments, within an interval of level 1e-6 in all.
controls (truths)
    Expect the positive control of each order to be verified, and the negative one to be refuted.
"""

from .benchmarks import parametrize_with_benchmarks
from .check import Check
from .claims import parametrize_with_claims, parametrize_with_examinations
from .questions import check_problem, check_scheme, parametrize_with_checks
from .table import checks

__all__ = [
    "Check",
    "check_problem",
    "check_scheme",
    "checks",
    "parametrize_with_benchmarks",
    "parametrize_with_checks",
    "parametrize_with_claims",
    "parametrize_with_examinations",
]
