"""Known mistakes of a refuted scheme, from the rates of its steps or from its modified equation.

If one step follows the equation, the terms of the modified equation identify mistakes of stages. For example, an
error only in derivatives with respect to time is due to the times at which coefficients are taken. A mistake is
reported only if the terms are exactly those that it causes.
"""

from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np

from sdaeverify import Array
from sdaeverify.studying import named_mistake

from ..classes import EquationClass
from ..conditions import STRONG, belongs
from ..examined import Examined
from ..grow import DRIFT, Tree, formula
from ..moments import Combination
from ..weights import NoStepError
from .equation import ModifiedEquation, modified_equation
from .sums import summed

# Weak order 1 suffices, because mistakes of stages cause errors of weight 4.
WEIGHT, STAGES = 4, 1.0
# Terms of a wrong mean over the stages of the drift: name of the mean, and symmetry of the forest.
STAGE_MEANS: dict[str, tuple[str, int]] = {
    "f(t)": ("of the time (in h)", 1),
    "f(f)": ("of the drift (in h f)", 1),
    "f(b1) . b1": ("of the noise (in B dW)", 1),
    "f(b1,b1)": ("of its variance (in h)", 2),
}
HALF_NEEDED = Fraction(1, 2)
CORRECTION = "Milstein's correction, the sum of DB_k B_j I_jk,"
TRANSPOSED = "the double integrals are transposed: I_kj is used in place of I_jk"
MIXED_LEFT_OUT = "the double integrals I_jk with different j and k are left out"
# Words: factors that have a name, and the relative accuracy to which they are those.
FACTORS, SAME = {0.0: "is left out", -1.0: "has the wrong sign", 0.5: "is halved", 2.0: "is doubled"}, 1e-6
OLD, HALF, NEW = Fraction(-1, 2), Fraction(0), Fraction(1, 2)
NEEDED = "the mean time of stages must be t + h/2"
# Terms (forest with motions as indices, coefficient) that a single mistake causes, and its description.
STAGE_MISTAKES: dict[frozenset[tuple[str, Fraction]], str] = {
    frozenset({("f(t)", OLD)}): f"the drift is evaluated only at t; {NEEDED}",
    frozenset({("f(t)", NEW)}): f"the stages of the drift have the mean time t + h; {NEEDED}",
    frozenset({("b1 . b1(t)", OLD)}): f"the diffusion is evaluated only at t; {NEEDED}",
    frozenset({("b1 . b1(t)", NEW)}): f"the stages of the diffusion have the mean time t + h; {NEEDED}",
    frozenset({("f(t)", OLD), ("b1 . b1(t)", OLD)}): f"all stages are evaluated at t; {NEEDED}",
    frozenset({("f(t)", NEW), ("b1 . b1(t)", NEW)}): f"all stages have the mean time t + h; {NEEDED}",
    frozenset({("f(f)", OLD)}): "no stage of the drift uses the drift",
    frozenset({("f(b1) . b1", OLD), ("f(b1,b1)", Fraction(-1, 4))}): "no stage of the drift uses the noise",
    frozenset({("f(b1,b1)", Fraction(-1, 8))}): (
        "the drift is evaluated once, at the midpoint: its noise has half the required variance"
    ),
}


def mistake_of(of: Examined, measure: str, order: float) -> str:
    """Return the mistake of a refuted scheme in a sentence, or an empty text if no known mistake explains all errors.

    Parameters
    ----------
    of : Examined
        Scheme that is refuted for the class.
    measure : str
        Of the refuted order.
    order : float
        Order from the conditions.
    """
    scheme, kind = of.probe.scheme, of.probe.kind
    if measure == STRONG and (named := integral_mistake(of)):
        return named
    if named := named_mistake(scheme, of.probe.problem, paths=measure == STRONG):
        return f"it solves another equation: {named}"
    if order != STAGES or not isinstance(kind, EquationClass) or kind.overdamped:
        return ""
    try:
        equation = modified_equation(scheme, kind, 2, WEIGHT)
    except NoStepError:
        return ""
    if measure == STRONG and not _stages_explain_paths(of, equation):
        return ""
    return stage_mistake(equation) or stage_means(equation)


def _stages_explain_paths(of: Examined, equation: ModifiedEquation) -> bool:
    """Return whether no condition on paths fails at the next order but that on f(b_j), by wrong noise in a stage."""
    needed = (each.forest[0] for each in of.breaking(STRONG) if each.on_paths and belongs(each, STRONG, STAGES + 0.5))
    failing = [*needed]
    of_noise = bool({"f(b1) . b1", "f(b1,b1)"} & _rational_terms(equation).keys())
    return not failing or (of_noise and all(map(_is_drift_of_noise, failing)))


def _is_drift_of_noise(each: Tree) -> bool:
    return each.weight == 3 and each.colour == DRIFT and all(kid.colour > DRIFT for kid in each.kids)


def stage_mistake(of: ModifiedEquation) -> str:
    """Return the mistake that causes exactly the terms of a modified equation, or an empty text.

    Parameters
    ----------
    of : ModifiedEquation
    """
    return STAGE_MISTAKES.get(frozenset(_rational_terms(of).items()), "")


def _rational_terms(of: ModifiedEquation) -> dict[str, Fraction]:
    terms = summed(of.terms, of.motions)
    return {formula(each.forest): Fraction(each.value).limit_denominator(96) for each in terms}


def stage_means(of: ModifiedEquation) -> str:
    """Return which means over the stages of the drift are wrong, or an empty text if there are other errors.

    With the drift h sum w_i f(t + c_i h, x + a_i h f + d_i B dW) they are sum w_i c_i, sum w_i a_i, sum w_i d_i and
    sum w_i d_i^2, each 1/2 for weak order 2.

    Parameters
    ----------
    of : ModifiedEquation
    """
    terms = _rational_terms(of)
    if not terms or not terms.keys() <= STAGE_MEANS.keys():
        return ""
    wrong = (
        f"{name} {HALF_NEEDED + symmetry * terms[each]}"
        for each, (name, symmetry) in STAGE_MEANS.items()
        if each in terms
    )
    return f"the weighted means over the stages of the drift must be 1/2, they are: {', '.join(wrong)}"


def integral_mistake(of: Examined) -> str:
    """Return what is wrong with the double integrals of a step of strong order 1/2, or an empty text.

    The weights of the trees b_k(b_j) must be I_jk. It is empty if other conditions of strong order 1 fail, too.

    Parameters
    ----------
    of : Examined
    """
    if not of.probe.fixed or not isinstance(of.probe.kind, EquationClass):
        return ""
    failing = [each for each in of.breaking(STRONG) if belongs(each, STRONG, 1.0)]
    if not failing or not all(each.on_paths and _is_double(each.forest[0]) for each in failing):
        return ""
    basis = of.probe.conditions.basis
    places = [i for i, each in enumerate(basis) if _is_double(next(iter(each)))]
    weighed = of.probe.at_points
    exact = weighed.nodes.increment(1.0).double_integrals(1.0)
    found, tolerance = weighed.psi[places], of.probe.tolerance
    for sentence, integrals in _wrong_integrals(found, [basis[i] for i in places], exact):
        if np.all(np.abs(found - integrals) <= tolerance * (1.0 + np.abs(integrals))):
            return sentence
    return ""


def _times(what: str, factor: float) -> str:
    words = next((words for value, words in FACTORS.items() if abs(factor - value) <= SAME), "")
    return f"{what} {words or f'is multiplied by {factor:.4g}'}"


def _is_double(each: Tree) -> bool:
    return each.weight == 2 and each.colour > DRIFT


def _wrong_integrals(found: Array, basis: Sequence[Combination], exact: Array) -> Iterator[tuple[str, Array]]:
    """Yield sentences with the weights that result, of the shape of those that are found."""

    def joined(integrals: Array) -> Array:
        rows = [
            [float(c) * integrals[each.kids[0].colour - 1, each.colour - 1] for each, c in some.items()]
            for some in basis
        ]
        return np.array([np.sum(row, axis=0) for row in rows])

    def factor(of: Array, part: Array) -> float:
        return float((of * part).sum() / max(float((part * part).sum()), np.finfo(float).tiny))

    whole, other = joined(exact), joined(exact.swapaxes(0, 1))
    same, areas = 0.5 * (whole + other), 0.5 * (whole - other)
    c = factor(found, whole)
    yield _times(CORRECTION, c), c * whole
    yield TRANSPOSED, other
    c = factor(found - same, areas)
    yield _times("the part of the Levy areas in the double integrals", c), same + c * areas
    yield MIXED_LEFT_OUT, joined(exact * np.eye(len(exact))[..., None])
