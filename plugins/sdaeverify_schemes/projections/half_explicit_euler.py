"""The half-explicit drift-truncated Euler scheme of Lindner & Stroot (2017), section 3.1."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sdaeverify import Array, Claim, HolonomicSDAE, HolonomicState, Increment, ParameterError, Scheme, Step, hookimpl
from sdaeverify.numerics import norm

from ._old_normals import onto_constraint

EVERY_H = Claim(measure="solvability", value="every h", source="Lindner & Stroot 2017, Theorem 3.4")
CONVERGES = Claim(measure="uniform", value="converges", source="Lindner & Stroot 2017, Theorem 4.1")
BOUNDED = Claim(measure="moments", value="bounded", source="Lindner & Stroot 2017, Lemma 4.12")


@dataclass(frozen=True)
class HalfExplicitEuler(Scheme):
    """Position along the old normal onto the constraint, velocity along the old normal onto the tangent space.

    With eta = min(1, C_eta / (h max(|v|, |v|^2, |a|))), (3.11), and the Brownian increment dw,

        r+ = r + eta h v + M^{-1} grad g(r) kappa,                     g(r+) = 0              (3.10a)
        v+ = v + M^{-1} [ eta h a + B dw + grad g(r) lambda ],         Dg(r+) v+ = 0          (3.10b)
        mu+ = mu + lambda

    where kappa is the root that Newton's method reaches from 0 with det[Dg(r+) M^{-1} grad g(r)] > 0.

    Attributes
    ----------
    truncation : str or float
        ``theory``: C_eta = 1/(4 C_g^3), and roots must satisfy |kappa| < C_kappa = 1/(8 C_g^4);
        ``none``: eta = 1; a number: C_eta. C_g is the problem's ``constraint_bound``: a problem that declares none
        is refused with ``theory`` and solved with ``none`` or a number.
    no_root : str
        Treatment of a path without admissible root, which is counted in any case: ``hold`` keeps its state, ``fail``
        makes it NaN; its kappa and lambda are the last iterates of Newton's method.
    """

    truncation: str | float = "theory"
    no_root: str = "hold"

    name: ClassVar[str] = "half-explicit-euler"
    form: ClassVar[type[HolonomicSDAE]] = HolonomicSDAE
    claims: ClassVar[tuple[Claim, ...]] = (
        Claim(measure="strong", value=0.5, source="measured; Theorem 4.1 gives convergence without rate"),
        Claim(
            measure="strong",
            value=1.0,
            when=frozenset({"vanishing-milstein-term"}),
            source="measured; Theorem 4.1 gives convergence without rate",
        ),
        Claim(measure="weak", value=1.0, source="measured"),
        Claim(measure="invariant", value=1.0, source="measured"),
        Claim(measure="drift", value="round-off", source="Lindner & Stroot 2017, (3.10)"),
        *(
            Claim(measure="multipliers", quantities=(quantity,), value=order, source="Lindner & Stroot 2017, (3.17)")
            for quantity, order in {"kappa": 2.0, "lambda remainder": 2.0, "Lambda remainder": 1.0}.items()
        ),
    )
    source: ClassVar[str] = "Lindner & Stroot 2017, (3.10)-(3.11)"

    def __post_init__(self) -> None:
        number = type(self.truncation) in {int, float} and 0.0 < self.truncation < np.inf
        if not (number or self.truncation in ("theory", "none")):
            raise ParameterError(f"truncation must be theory, none or a positive C_eta, got {self.truncation!r}")
        if self.no_root not in {"hold", "fail"}:
            raise ParameterError(f"no_root must be hold or fail, got {self.no_root!r}")

    @property
    def promises(self) -> tuple[Claim, ...]:
        """Claims: with the constants of the theory its theorems, with any truncation bounded moments."""
        theorems = (EVERY_H, CONVERGES) if self.truncation == "theory" else ()
        return (*self.claims, *theorems, *((BOUNDED,) if self.truncation != "none" else ()))

    def refuses(self, problem: HolonomicSDAE) -> str:
        """Refuse the theoretical truncation if C_g is unknown."""
        if self.truncation == "theory" and problem.constraint_bound is None:
            return "truncation=theory needs the problem's constraint_bound C_g; use truncation=none or a number"
        return ""

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        r, v, mu = state
        a = problem.force(t, r, v)
        eta = self._truncation_factor(problem, v, a, h)
        part = eta * h
        old = problem.linearised(r)
        r_new, J, kappa, A, found, iterations = onto_constraint(problem, r + part * v, old)
        failed = ~found
        if self.truncation == "theory":
            failed |= norm(kappa) >= 1.0 / (8.0 * problem.constraint_bound**4)
        x = v + problem.inverse_mass(part * a + problem.diffused(t, r, v, noise.dW))
        lam = -A.solve(J.times(x))
        new = HolonomicState(r_new, x + problem.push(old, lam), mu + lam)
        if failed.any():
            new = self._without_root(state, new, failed)
        truncated = None if self.truncation == "none" else eta < 1.0
        multipliers, costs = {"kappa": kappa, "lambda": lam}, {"newton_iterations": iterations}
        return Step(new, failed, truncated, multipliers, costs)

    def _truncation_factor(self, problem: HolonomicSDAE, v: Array, a: Array, h: float) -> Array | float:
        if self.truncation == "none":
            return 1.0
        C_g = problem.constraint_bound
        C_eta = 1.0 / (4.0 * C_g**3) if self.truncation == "theory" else self.truncation
        speed = norm(v)
        return C_eta / np.maximum(C_eta, h * np.maximum(speed * np.maximum(speed, 1.0), norm(a)))

    def _without_root(self, old: HolonomicState, new: HolonomicState, failed: Array) -> HolonomicState:
        kept = old if self.no_root == "hold" else HolonomicState(*(np.full_like(part, np.nan) for part in old))
        return HolonomicState(*(np.where(failed, o, n) for o, n in zip(kept, new, strict=True)))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the scheme with the truncation of the theory and without truncation."""
    return [HalfExplicitEuler(), HalfExplicitEuler(truncation="none")]
