"""A registered problem with other numbers: fibre-free, alpha=4.0, beta=0.0669, N=2, d=3, horizon=horizon."""

from sdaeverify import hookimpl
from sdaeverify_problems.fibres.fibre_free import fibre_free as registered


def counterexample(horizon: float = 0.05):
    """Return the problem."""
    return registered(alpha=4.0, beta=0.0669, N=2, d=3, horizon=horizon)


@hookimpl
def sdaeverify_problems():
    """Register the problem."""
    return [counterexample]
