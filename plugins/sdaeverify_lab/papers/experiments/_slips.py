"""Slips in the proofs of the papers: the printed line, the right one, and a number in which they differ."""

from collections.abc import Mapping

import numpy as np

from sdaeverify import Array, HolonomicState, Increment, Problem, Scheme
from sdaeverify_lab.papers import Probe, TableEntry

SPHERE, HALF_EXPLICIT = "sphere-langevin[m_1=1,m_2=2,m_3=4]", "half-explicit-euler[truncation=none]"


def lost_mass(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return |g(r + h v + M^{-1} grad g kappa)| of a solved step, and the same without M^{-1}, M = diag(1, 2, 4)."""
    (problem,), (scheme,) = problems, schemes
    r, v, h = np.array([[0.6], [0.0], [0.8]]), np.array([[0.4], [1.0], [-0.3]]), 0.1
    still = Increment(np.zeros((problem.noise_dim, 1)), None)
    kappa = scheme.step(problem, HolonomicState(r, v, np.zeros((1, 1))), 0.0, h, still).outputs["kappa"]
    normal = np.swapaxes(problem.dg(r), 0, 1)[:, 0] * kappa
    return {
        "right": np.abs(problem.constraint(r + h * v + problem.inverse_mass(normal))[0]),
        "printed": np.abs(problem.constraint(r + h * v + normal)[0]),
    }


def truncation_bound(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return |eta - 1| over its bound C_eta^{-1} (|x| + |x|^2 + |a|) h, x = v and x = r, pendulum, |v| = 100."""
    (problem,) = problems
    speed, h, C_eta = 100.0, 0.01, 0.25 * problem.constraint_bound**-3
    a = float(np.linalg.norm(problem.force(0.0, np.array([[0.0], [-1.0]]), np.array([[speed], [0.0]]))))
    off = 1.0 - min(1.0, C_eta / (max(speed, speed**2, a) * h))
    bounds = {name: (x + x * x + a) * h / C_eta for name, x in (("right", speed), ("printed", 1.0))}
    return {name: np.array([off / bound]) for name, bound in bounds.items()}


def theta_step(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return how far the two sides of (4.2) are apart for a theta step of dx = (a x + b x(t - tau)) dt + c x dW.

    (4.2) is the square of x_{n+1} - theta h f_{n+1} = x_n + (1 - theta) h f_n + g_n DW: the term 2 h theta f_{n+1}
    stands with x_{n+1}, not with x_n.
    """
    a, b, c, theta, h, dw = -1.0, 0.5, 0.7, 0.4, 0.25, 0.3
    x, lag, new_lag = 1.0, 0.9, 0.95
    f, g = a * x + b * lag, c * x
    new = (x + h * (theta * b * new_lag + (1.0 - theta) * f) + g * dw) / (1.0 - h * theta * a)
    new_f = a * new + b * new_lag
    rest = (x + (1.0 - theta) * h * f + g * dw) ** 2 - (theta * h * new_f) ** 2
    sides = {name: rest + 2.0 * h * theta * point * new_f for name, point in (("right", new), ("printed", x))}
    return {name: np.array([abs(new**2 - side)]) for name, side in sides.items()}


def delay_condition(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return the largest a that each condition admits, and the rate of E x^2, for b = d = l = 0 and c = 1.

    dx = a x dt + c x dW has E x^2 = exp((2 a + c^2) t): mean-square stable for a < -1/2 alone.
    """
    c, d, lag = 1.0, 0.0, 0.0
    right, printed = (0.0 - 0.5 * (first * abs(c) + abs(d)) ** 2 for first in (1.0, lag))
    between = 0.5 * (right + printed)
    return {"right": np.array([right]), "printed": np.array([printed]), "rate": np.array([2.0 * between + c * c])}


SLIPS = {
    "mass": Probe(lost_mass, (SPHERE,), (HALF_EXPLICIT,)),
    "bound": Probe(truncation_bound, ("pendulum",)),
    "theta": Probe(theta_step),
    "condition": Probe(delay_condition),
}
MASS = "LS proof of Theorem 3.4, steps 3 and 6: printed g(r + eta v h + grad g kappa); right M^{-1} grad g kappa"
BOUND = "LS proof of Lemma 4.12: printed |x^(1)|, |x^(1)|^2 in the bound of |eta - 1|; right |x^(2)|, of velocities"
THETA = "Qu (4.2): printed 2 h theta x_n^T f(x_{n+1}, ...); right x_{n+1}^T f; y_{n+1}, not y_n, in the line before"
CONDITION = "Qu section 5, set II: printed a < -|b| - (l|c| + |d|)^2/2; right (|c| + |d|)^2/2"
# Found by reading alone: sizes of matrices, numbers of statements.
READ = (
    "By sizes and references alone: Laurent section 2 prints Pi = I - G^{-1} g g^T, right I - g G^{-1} g^T, as G is "
    "q by q and g g^T d by d; LS before (4.72) multiplies D^2 g(y, y) of R^m by Dg M^{-1}, right is (2.8); LS "
    "section 4.4 quotes a Corollary 4.3, right 4.14, as 4.3 is a notation; LF after (3.7) f takes values in R, right "
    "R^N; Qu (4.5) squares the terms of |f| twice.",
    "Looked for and not found: an error in LF (3.7) itself, which holds for the stopped processes; a third line with "
    "|x^(1)| in LS Lemma 4.12, where two have it.",
)


def slip_entries(found: Mapping[str, Mapping[str, Array]]) -> list[TableEntry]:
    """Return the numbers of the slips, the printed line beside the right one.

    Parameters
    ----------
    found : mapping of str to mapping of str to ndarray
        What the probes of `SLIPS` gave.
    """
    pairs = (
        (MASS, "mass", "|g| at the step's own kappa, M = diag(1, 2, 4)", 0.0),
        (BOUND, "bound", "|eta - 1| over its bound, at most 1; |v| = 100, h = 0.01", np.nan),
        (THETA, "theta", "difference of the two sides of (4.2)", 0.0),
    )
    entries = [
        _entry(group, f"{of}, {name}", found[key][name][0], exact)
        for group, key, of, exact in pairs
        for name in ("right", "printed")
    ]
    stable = found["condition"]
    return [
        *entries,
        _entry(CONDITION, "largest a for b = d = l = 0, c = 1, right", stable["right"][0], -0.5),
        _entry(CONDITION, "largest a, printed", stable["printed"][0], -0.5),
        _entry(CONDITION, "rate of E x^2 at the a between, which is said to be stable", stable["rate"][0]),
    ]


def _entry(group: str, of: str, value: float, exact: float = np.nan) -> TableEntry:
    return TableEntry(group, {"of": of}, float(value), exact=exact)
