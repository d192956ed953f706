"""A fine reference for constrained mechanics whose noise does not depend on velocities: SRA1 on the inherent SDE."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from sdaeverify import Array, HolonomicSDAE, HolonomicState, Increment, Pathwise, ProblemError

SOURCE = "Roessler's SRA1 (2010, section 6) on the inherent SDE, order 3/2"


def inherent_truth(problem: HolonomicSDAE) -> Pathwise:
    """Return the solution of the inherent SDE by a Runge-Kutta step of strong order 3/2, rows (r, v, mu).

    Let R(r, v, s, y) be the change of v and mu by an impulse y when the constraint acts at r for a time s,

        lambda = -G_M^{-1} { Dg M^{-1} y + s D^2 g(v, v) },   R = ( M^{-1} [ y + grad g lambda ], lambda ).

    With I = int (w - w_n) ds, the stage (r', v') and w' = (4/3) (dw - I/h), one step is

        r' = r + (3/4) h v,                           v' = v + R_v(r, v, (3/4) h, (3/4) h a + (3/2) B I/h)
        r+ = r + (h/3) (v + 2 v'),
        (v+, mu+) = (v, mu) + R(r, v, h/3, (h/3) a + B (dw - w')) + R(r', v', (2/3) h, (2/3) h a' + B' w')

    where a, B are evaluated at (t, r, v) and a', B' at (t + (3/4) h, r', v'). The step is SRA1 except for the point
    of the second evaluation of B. As r has finite variation, the noise of the inherent SDE varies like a function of
    time: the only additional term of order 3/2 is its rate of change times h dw - I = (3/4) h w', which the term with
    w' contains.

    The step needs only products with Dg and B and solutions of Gram systems, so that a chain of N points costs O(N).

    Parameters
    ----------
    problem : HolonomicSDAE
        Problem with a noise coefficient B(t, r) that does not depend on v.

    Returns
    -------
    Pathwise

    Raises
    ------
    ProblemError
        If B depends on v, because the step would be of order 1/2.
    """
    _check_noise(problem)

    def advance(z: Array, t: float, h: float, noise: Increment) -> Array:
        return np.concatenate(_step(problem, problem.state(z), t, h, noise))

    return Pathwise(
        start=lambda paths: np.concatenate(problem.initial(paths)),
        advance=advance,
        parts=lambda t, z: problem.parts(problem.state(z)),
        order=1.5,
        source=SOURCE,
    )


def with_inherent_truth(problem: HolonomicSDAE) -> HolonomicSDAE:
    """Return the problem with the fine reference as first truth."""
    return replace(problem, truths=(inherent_truth(problem), *problem.truths))


def _step(problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> HolonomicState:
    r, v, mu = state
    # I/h, which is defined for h = 0, too.
    mean = noise.time_integral(1.0)
    late = 4.0 / 3.0 * (noise.dW - mean)

    here = _response(problem, t, r, v)
    later = v + here(0.75 * h, 1.5 * mean)[0]
    there = _response(problem, t + 0.75 * h, r + 0.75 * h * v, later)
    (first, lam), (second, more) = here(h / 3.0, noise.dW - late), there(2.0 / 3.0 * h, late)
    return HolonomicState(r + h / 3.0 * (v + 2.0 * later), v + first + second, mu + lam + more)


def _response(problem: HolonomicSDAE, t: float, r: Array, v: Array) -> Callable[[float, Array], tuple[Array, Array]]:
    J, a = problem.linearised(r), problem.force(t, r, v)

    def response(s: float, w: Array) -> tuple[Array, Array]:
        """Return R(r, v, s, s a + B w)."""
        impulse = s * a + problem.diffused(t, r, v, w)
        # D^2 g is bilinear: s D^2 g(v, v) = D^2 g(sqrt(s) v, sqrt(s) v).
        lam = problem.inherent_multiplier(J, r, np.sqrt(s) * v, impulse)
        return problem.inverse_mass(impulse) + problem.push(J, lam), lam

    return response


def _check_noise(problem: HolonomicSDAE) -> None:
    r, v, _ = problem.initial(1)
    w = np.cos(np.arange(problem.noise_dim))[:, None]
    faster = v + 1.0 + np.abs(v)
    for t in (0.0, 0.5 * problem.horizon):
        if not np.array_equal(problem.diffused(t, r, v, w), problem.diffused(t, r, faster, w)):
            raise ProblemError("a reference by SRA1 needs a diffusion that does not depend on v")
