"""What a refuted scheme did instead: from the rates of its steps, or from which terms of h alone are wrong.

Where one step follows the equation, the terms of the modified equation tell mistakes of stages: an error that shows
in derivatives by time alone is one of the times at which coefficients are taken, and so on. A mistake is named only
if the terms are exactly those that it makes.
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

# Weak order 1 needs no more: mistakes of stages are errors of the weight 4.
WEIGHT, STAGES = 4, 1.0
OLD, HALF, NEW = Fraction(-1, 2), Fraction(0), Fraction(1, 2)
# Terms (forest with motions as indices, coefficient) that a mistake alone makes, and the mistake.
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
    """Return in a sentence what a scheme did instead, or an empty text if no mistake explains all of it.

    Parameters
    ----------
    scheme : Scheme
        That is refuted for a class.
    kind : EquationClass or TreeClass
        The class.
    problem : Problem
        A random equation of it.
    order : float
        That conditions give.
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
    """Return the mistake that makes exactly the terms of a modified equation, or an empty text.

    Parameters
    ----------
    of : ModifiedEquation
    """
    terms = summed(of.terms, of.motions)
    found = frozenset((formula(each.forest), Fraction(each.value).limit_denominator(96)) for each in terms)
    return STAGE_MISTAKES.get(found, "")
