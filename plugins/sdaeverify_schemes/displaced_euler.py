"""A negative control: a scheme that does not converge to the solution."""

from typing import ClassVar

from sdaeverify import SDE, Array, Increment, Scheme, Step, hookimpl


class DisplacedEuler(Scheme):
    """x+ = x + f(t, y) h + B(t, y) dW with y = 1.05 x + 0.05: Euler-Maruyama with displaced coefficients.

    The scheme is right for constant coefficients. Otherwise it converges with an order, but to the solution of
    another equation. It has no claims; problems use it as their negative control of the lowest order.
    """

    name: ClassVar[str] = "displaced-euler"
    form: ClassVar[type[SDE]] = SDE
    source: ClassVar[str] = "negative control"

    def step(self, problem: SDE, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step; the state x has shape (d, P)."""
        x = state
        y = 1.05 * x + 0.05
        return Step(x + h * problem.drift(t, y) + problem.diffused(t, y, noise.dW))


@hookimpl
def sdaeverify_schemes() -> list[Scheme]:
    """Register the control."""
    return [DisplacedEuler()]
