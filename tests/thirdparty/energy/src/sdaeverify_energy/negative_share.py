"""Share of negative paths: on how many paths a scheme leaves the half-line on which the equation stays."""

from sdaeverify import hookimpl
from sdaeverify.measuring import ScalarMeasure


class NegativeShare(ScalarMeasure):
    """Share of the paths on which a component is negative at a time of the coarsest grid."""

    name, value_of = "negative-share", "share of negative paths"

    def number(self, problem, t, parts):
        """Return 1 for each path that is negative, and 0 for the others."""
        return (parts["x"] < 0.0).any(axis=0)


@hookimpl
def sdaeverify_measures():
    """Register the measure."""
    return [NegativeShare()]
