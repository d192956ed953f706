"""Lemma 9 of Lindner et al. (2018): det G >= (2 ds)^(-2N) within ds/4 of the manifold of inextensible fibres."""

from collections.abc import Mapping

import numpy as np

from sdaeverify import Array, Problem, Scheme, hookimpl
from sdaeverify_lab.papers import (
    Budget,
    Curve,
    Exhibit,
    Experiment,
    ExperimentEvidence,
    Panel,
    Probe,
    TableEntry,
    Work,
)

from ._fibres import spacing

POINTS, DRAWS = (2, 3, 5, 10, 20, 40), 2000


def determinants(problems: tuple[Problem, ...], schemes: tuple[Scheme, ...]) -> Mapping[str, Array]:
    """Return the least log(det G (2 ds)^(2N))/N over fibres near the manifold, and where the bound is least slack.

    Draws: chains of N segments of length ds with random angles, and the straight one, displaced by ds/4 in a random
    direction of R^(2N), or along the first segment, which is the shortest then.
    """
    return {"least": np.array([_least(problem) for problem in problems])}


def _least(problem: Problem) -> float:
    rng = np.random.Generator(np.random.Philox(key=9))
    N = problem.constraints
    ds = spacing(N)
    x = _displaced(_chains(N, ds, rng), ds, rng)
    J = np.moveaxis(problem.dg(x), 2, 0)
    sign, log = np.linalg.slogdet(J @ np.swapaxes(J, 1, 2))
    return float(np.where(sign > 0.0, log, -np.inf).min() / N + 2.0 * np.log(2.0 * ds))


def _chains(N: int, ds: float, rng: np.random.Generator) -> Array:
    """Return points of the manifold, shape (N, 2, P): half of them straight, the others with turns of all sizes."""
    turns = rng.standard_normal((N, DRAWS)) * rng.uniform(0.0, np.pi, DRAWS)
    turns[:, : DRAWS // 2] = 0.0
    angles = np.cumsum(turns, axis=0)
    points: Array = np.cumsum(ds * np.stack([np.cos(angles), np.sin(angles)], axis=1), axis=0)
    return points + _root(ds)


def _root(ds: float) -> Array:
    """Return r_0, shape (2, 1)."""
    return np.array([[0.0], [-0.5 * ds]])


def _displaced(x: Array, ds: float, rng: np.random.Generator) -> Array:
    """Return points at ds/4 from x, shape (2 N, P): in random directions, and along the first segment."""
    push = rng.standard_normal(x.shape)
    push[:, :, ::2] = 0.0
    push[0, :, ::2] = (_root(ds) - x[0])[:, ::2]
    push *= 0.25 * ds / np.sqrt((push**2).sum(axis=(0, 1)))
    flat: Array = (x + push).reshape(-1, x.shape[-1])
    return flat


class GramDeterminant(Experiment):
    """The least determinant near the manifold beside the bound of the lemma."""

    name = "lindner-2018-lemma-9"
    title = "determinant of the Gram matrix of a fibre within ds/4 of the manifold, and its bound"
    source = "Lindner et al. 2018, Lemma 9"
    paths = 2
    notes = (
        "log(det G (2 ds)^(2N))/N is at least 0 by the lemma. The bound shortens all segments to ds/2 at once, which "
        "no point within ds/4 does in the norm of R^(2N): it is far from sharp.",
        f"{DRAWS} fibres each, half of them straight, whose determinant of G~ is the least, 1.",
    )

    def work(self, budget: Budget) -> Work:
        """Return one probe of fibres of several numbers of points."""
        return {"determinants": Probe(determinants, tuple(f"fibre-clamped[N={N}]" for N in POINTS))}

    def exhibit(self, evidence: ExperimentEvidence) -> Exhibit:
        """Return the least determinant by N."""
        least = evidence.probe("determinants")["least"]
        group = "least log(det G (2 ds)^(2N))/N, bound 0; of the straight fibre itself log 4 = 1.386"
        entries = [TableEntry(group, {"N": N}, float(value)) for N, value in zip(POINTS, least, strict=True)]
        x = np.array(POINTS, dtype=float)
        curves = (Curve("least found", x, least), Curve("bound of the lemma", x, 0.0 * x, kind="guide"))
        return Exhibit(tuple(entries), (Panel("fibres within ds/4", "N", "log(det G (2 ds)^(2N))/N", curves, "x"),))


@hookimpl
def sdaeverify_experiments() -> list[Experiment]:
    """Register the determinants."""
    return [GramDeterminant()]
