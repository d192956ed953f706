"""Traits: properties of problems that claims may require, declared by a form, a scheme or a measure."""

from collections.abc import Callable, Iterable
from typing import Any

from ..contracts.spelling import did_you_mean


class Trait(str):
    """A property of a problem, represented by its name in comparisons and tables.

    A problem may declare it, and a claim may require it, as this object, or by its name if a form declares it.

    Parameters
    ----------
    name : str
        In lower case with hyphens.
    meaning : str
        The property that the problem has, in a line or two.
    against : callable, problem -> str, optional
        Evaluates the problem and returns evidence against the trait, or an empty string; used by the conformance kit.
    """

    __slots__ = ("against", "meaning")

    def __new__(cls, name: str, meaning: str, against: Callable[[Any], str] | None = None) -> "Trait":
        """Return the name with its meaning."""
        trait = super().__new__(cls, name)
        trait.meaning, trait.against = meaning, against
        return trait

    meaning: str
    against: Callable[[Any], str] | None

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the constructor and its arguments, for pickling."""
        return Trait, (str(self), self.meaning, self.against)


GENERAL: tuple[Trait, ...] = (
    Trait("scalar-noise", "One Brownian motion (set by the form itself)."),
    Trait("diagonal-noise", "The diffusion matrix is diagonal and its j-th entry depends on component j alone."),
    Trait("additive-noise", "The diffusion matrix depends neither on the state nor on time."),
    Trait(
        "commutative-noise",
        "DB_j(x) B_k(x) = DB_k(x) B_j(x) for all columns of the diffusion of the SDE (of the inherent SDE, for a "
        "constrained problem), so that no Levy area counts for strong order 1 (set by the form where the noise is "
        "scalar, diagonal or additive, or the Milstein term vanishes).",
    ),
    Trait(
        "vanishing-milstein-term",
        "DB_j(x) B_k(x) = 0 for all columns of the diffusion of the SDE (of the inherent SDE, for a constrained "
        "problem), so that Euler-Maruyama is Milstein's scheme.",
    ),
    Trait(
        "overdamped-gradient",
        "The drift is -grad V and does not depend on time, the diffusion is sigma Id with a constant number sigma: "
        "the invariant density, where there is one, is proportional to exp(-2 V/sigma^2).",
    ),
    Trait(
        "normal-milstein-term",
        "DB_j(x) B_k(x) is orthogonal to the manifold g = 0 of an SDE's constraint, at points x of it, so that a "
        "projection supplies what Euler-Maruyama lacks.",
    ),
    Trait(
        "unconstrained",
        "No constraint was eliminated or left to the scheme (set by the form itself): what does not project cannot "
        "leave a manifold in the long run.",
    ),
    Trait("constrained", "It has constraints, eliminated or not (set by the form itself)."),
    Trait(
        "linear-growth",
        "Drift and diffusion of an SDE grow at most linearly with the state, as globally Lipschitz ones do (set by "
        "the form itself, which evaluates them along rays).",
    ),
    Trait(
        "nonnegative",
        "All components stay at or above 0 (set by the form itself, if the domain of the problem says so).",
    ),
    Trait("no-delay", "No coefficient depends on the past (set by the form itself)."),
)
INDEX_ONE: tuple[Trait, ...] = (
    Trait(
        "algebraic",
        "Its constraint determines algebraic components that a step solves for: index 1 (set by the form itself).",
    ),
    Trait(
        "dissipative",
        "It satisfies the sufficient condition (4.1) of Qu, Huang & Liu (2010) for mean-square stability, as it is "
        "or with y eliminated (set by the form).",
    ),
    Trait("delayed-noise", "The diffusion of a delay equation depends on time and the delayed state alone."),
)
# Traits that forms set themselves: declarations by authors do not add them.
SET_BY_FORM = frozenset({"scalar-noise", "unconstrained", "constrained", "no-delay", "algebraic", "nonnegative"})
# Each of these implies commutative noise.
COMMUTING = frozenset({"scalar-noise", "diagonal-noise", "additive-noise", "vanishing-milstein-term"})
# Additive noise and the traits that it implies.
ADDITIVE = frozenset({"additive-noise", "vanishing-milstein-term", "commutative-noise"})
DECLARED = {str(trait): trait for trait in (*GENERAL, *INDEX_ONE)}


def known_traits(form: type = object) -> dict[str, Trait]:
    """Return the traits of the framework, and those that a form and its bases declare, by name."""
    own = (trait for base in form.__mro__ for trait in vars(base).get("declared_traits", ()))
    return {**DECLARED, **{str(trait): trait for trait in own}}


def why_unknown(given: Iterable[str], form: type = object) -> str:
    """Return which of the given traits are undeclared, with suggestions; a `Trait` object declares itself."""
    bare, known = {trait for trait in given if not isinstance(trait, Trait)}, known_traits(form)
    unknown = sorted(bare - known.keys())
    if not unknown:
        return ""
    meant = did_you_mean(unknown[0], known)
    own = f"; to declare one of your own, give Trait({unknown[0]!r}, meaning) in place of the text"
    return f"unknown traits {unknown}; known are {sorted(known)}{meant}{own}"
