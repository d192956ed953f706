"""What the half-explicit scheme claims, by its truncation."""

import pytest

from facade import HalfExplicitEuler


@pytest.mark.parametrize(
    ("truncation", "further"),
    [("theory", {"every h", "converges", "bounded"}), (0.5, {"bounded"}), ("none", set())],
)
def test_claims_depend_on_the_truncation(truncation: str | float, further: set[str]) -> None:
    """A root and convergence are claimed with the constants of the theory, bounded moments with any truncation."""
    scheme = HalfExplicitEuler(truncation=truncation)

    assert {str(claim) for claim in scheme.promises if claim not in scheme.claims} == further
    exponents = {
        claim.quantities[0]: claim.value.least for claim in scheme.promises if claim.measure == "multipliers"
    }
    assert exponents == {"kappa": 2.0, "lambda remainder": 2.0, "Lambda remainder": 1.0}
