"""The implicit Euler scheme in GGL form with one of its parts changed; it claims what the right scheme keeps."""

from dataclasses import dataclass
from typing import ClassVar

from sdaeverify import Array, Claim, HolonomicSDAE, HolonomicState, Increment, Scheme, Step, hookimpl
from sdaeverify_lab import Planted
from sdaeverify_schemes.ggl.implicit_euler_ggl import TO_ROUNDING, ImplicitEulerGGL


@dataclass(frozen=True)
class WrongImplicitEuler(ImplicitEulerGGL):
    """The scheme with other data in its equations, or with another use of their solution.

    Attributes
    ----------
    noise_at : str
        State in B dw: the ``old`` one, which is right, or the ``new`` one, first found with the old.
    force : float
        Part of h a that acts; the rest is taken away at the old state.
    velocity : str
        The ``solved`` one, which is right, or the ``quotient`` of positions by h, which has no hidden constraint.
    multiplier : float
        Factor of h lambda in mu.
    """

    noise_at: str = "old"
    force: float = 1.0
    velocity: str = "solved"
    multiplier: float = 1.0

    name: ClassVar[str] = "planted-implicit-euler-ggl"

    @property
    def promises(self) -> tuple[Claim, ...]:
        """All of the claims, whatever the tolerance, but that about the invariant law: chains would take minutes."""
        return (*(claim for claim in self.claims if claim.measure != "invariant"), TO_ROUNDING)

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        step = super().step(problem, state, t, h, noise)
        new = step.state._replace(mu=state.mu + self.multiplier * (step.state.mu - state.mu))
        if self.velocity == "quotient":
            new = new._replace(v=(new.r - state.r) / h)
        return step._replace(state=new)

    def _kick(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Array:
        r, v, _ = state
        at = r, v
        if self.noise_at == "new":
            first = ImplicitEulerGGL().step(problem, state, t, h, noise).state
            at = first.r, first.v
        return problem.diffused(t, *at, noise.dW) - (1.0 - self.force) * h * problem.force(t, r, v)


@hookimpl
def sdaeverify_planted() -> list[Planted]:
    """Register the bugs."""
    bugs: dict[str, Scheme] = {
        "half of the force": WrongImplicitEuler(force=0.5),
        "velocity from positions, hidden constraint dropped": WrongImplicitEuler(velocity="quotient"),
        "multiplier sign": WrongImplicitEuler(multiplier=-1.0),
        "Newton's method ended early": WrongImplicitEuler(tolerance=1e-3),
    }
    ito = WrongImplicitEuler(noise_at="new")
    return [
        *(Planted(bug=f"implicit Euler: {b}", scheme=s, problem="damped-pendulum") for b, s in bugs.items()),
        Planted(bug="implicit Euler: noise at the new velocity", scheme=ito, problem="pendulum-velocity-noise"),
    ]
