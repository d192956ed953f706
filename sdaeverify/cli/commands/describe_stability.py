"""What is known of the mean-square stability of an equation with a delay, in lines for the terminal."""

from ...forms import DelaySDAE, Dissipation
from ...probe.linear.delay_map import LARGE, SMALL, at_rest, is_autonomous, is_scalar, linear_delay

THETAS = (0.0, 0.25, 0.5, 1.0)


def stability_lines(problem: DelaySDAE) -> list[str]:
    """Return growth rates, condition (4.1) with its constants and the step sizes it promises; empty without delay."""
    if not problem.delay:
        return []
    lines = [*_growth(problem), *(_condition(problem.dissipation) if problem.dissipation else [])]
    given = problem.dissipation_without_y
    if given and not (problem.dissipation and given.C <= problem.dissipation.C):
        lines += [f"with y eliminated, {line}" for line in _condition(given)]
    return ["mean-square stability:", *(f"  {line}" for line in lines)] if lines else []


def _growth(problem: DelaySDAE) -> list[str]:
    if not (is_scalar(problem) and at_rest(problem) and is_autonomous(problem)):
        return []
    small, large = (linear_delay(problem, size).growth_rate for size in (SMALL, LARGE))
    between = (
        "" if abs(large - small) <= 1e-9 * (1.0 + abs(small)) else f" at small states, {large:.5g} at large ones"
    )
    return [f"growth rate of E x^2: {small:.5g}{between}"]


def _condition(known: Dissipation) -> list[str]:
    constants = ", ".join(f"{name} = {value:g}" for name, value in known._asdict().items())
    if known.C <= 0.0:
        return [f"condition (4.1) fails: C = {known.C:g}; {constants}"]
    steps = ((theta, known.largest_step(theta), known.sharpened(theta)) for theta in THETAS)
    bounds = [f"theta = {theta:g}: stable below h_0 = {h:.5g}, sharpened {more:.5g}" for theta, h, more in steps]
    return [f"condition (4.1) holds: C = {known.C:g}; {constants}", *bounds]
