"""Known mistakes of a refuted scheme, from the rates of its steps or from its modified equation.

If one step follows the equation, the terms of the modified equation identify mistakes of stages. For example, an
error only in derivatives with respect to time is due to the times at which coefficients are taken. A mistake is
reported only if the terms are exactly those that it causes.
"""

from fractions import Fraction

from ...contracts.scheme import Scheme
from ...forms import Problem
from ...probe.local.solved_instead import solved_instead
from .. import TreeClass
from ..classes import EquationClass
from ..grow import formula
from ..weights import NoStepError
from .equation import ModifiedEquation, modified_equation
from .sums import summed

# Weak order 1 suffices, because mistakes of stages cause errors of weight 4.
WEIGHT, STAGES = 4, 1.0
OLD, HALF, NEW = Fraction(-1, 2), Fraction(0), Fraction(1, 2)
# Terms (forest with motions as indices, coefficient) that a single mistake causes, and its description.
STAGE_MISTAKES: dict[frozenset[tuple[str, Fraction]], str] = {
    frozenset({("f(t)", OLD)}): "the drift is taken at t alone, where later stages need t + h",
    frozenset({("f(t)", NEW)}): "the drift is taken at t + h alone, where the first stage needs t",
    frozenset({("b1 . b1(t)", OLD)}): "the diffusion is taken at t alone, where later stages need t + h",
    frozenset({("b1 . b1(t)", NEW)}): "the diffusion is taken at t + h alone, where the first stage needs t",
    frozenset({("f(t)", OLD), ("b1 . b1(t)", OLD)}): "time stands still within a step: all stages are at t",
    frozenset({("f(t)", NEW), ("b1 . b1(t)", NEW)}): "all stages are at t + h",
    frozenset({("f(f)", OLD)}): "no stage of the drift is moved by the drift",
    frozenset({("f(b1) . b1", OLD), ("f(b1,b1)", Fraction(-1, 4))}): "no stage of the drift is moved by the noise",
    frozenset({("f(b1,b1)", Fraction(-1, 8))}): (
        "the drift is taken once, at the midpoint: the noise in its argument has half the variance that is needed"
    ),
}


def mistake_of(scheme: Scheme, kind: EquationClass | TreeClass, problem: Problem, order: float) -> str:
    """Return the mistake of a scheme in a sentence, or an empty text if no known mistake explains all terms.

    Parameters
    ----------
    scheme : Scheme
        Scheme that is refuted for the class.
    kind : EquationClass or TreeClass
        Class of equations.
    problem : Problem
        Random equation of the class.
    order : float
        Order from the conditions.
    """
    if named := solved_instead(scheme, problem):
        return f"it solves another equation: {named}"
    if order != STAGES or not isinstance(kind, EquationClass) or kind.overdamped:
        return ""
    try:
        return stage_mistake(modified_equation(scheme, kind, 2, WEIGHT))
    except NoStepError:
        return ""


def stage_mistake(of: ModifiedEquation) -> str:
    """Return the mistake that causes exactly the terms of a modified equation, or an empty text.

    Parameters
    ----------
    of : ModifiedEquation
    """
    terms = summed(of.terms, of.motions)
    found = frozenset((formula(each.forest), Fraction(each.value).limit_denominator(96)) for each in terms)
    return STAGE_MISTAKES.get(found, "")
