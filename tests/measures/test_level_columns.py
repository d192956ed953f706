"""What each level row says beside its estimate: what went wrong, and what the steps took."""

from typing import ClassVar

import numpy as np
import pytest

from facade import ExplicitProjectionEuler, HalfExplicitEuler, pendulum
from sdaeverify import Claim, verify


class Convergent(HalfExplicitEuler):
    """The half-explicit scheme that claims to converge, whatever its truncation."""

    name: ClassVar[str] = "convergent"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="uniform", value="converges", source="test"),)


def fast():
    """Return the pendulum with a start so fast that coarse steps are truncated, or have no root."""
    return pendulum(omega_0=5.0)


@pytest.mark.long
@pytest.mark.parametrize("measure", ["strong", "drift", "uniform"])
def test_failures_truncation_and_iterations_are_columns(measure):
    """Each level row of a sampled measure has them; they are those of the step size, whatever the quantity."""
    schemes = [Convergent("none"), Convergent("theory")]
    levels = verify(schemes, [fast], measure, paths=80, levels=3, block=80).levels

    free, truncated = (levels[levels.scheme == scheme.label] for scheme in schemes)
    assert np.isfinite(levels[["failed_paths", "lost_paths", "truncated_share", "mean_newton_iterations"]]).all(
        axis=None
    )
    assert (levels.groupby(["scheme", "h"])["mean_newton_iterations"].nunique() == 1).all()
    assert (levels["mean_newton_iterations"] > 1.0).all()
    assert free["failed_paths"].max() > 0
    assert free["truncated_share"].max() == 0.0
    assert truncated["failed_paths"].max() == 0
    assert truncated["truncated_share"].max() > 0.5


@pytest.mark.long
def test_what_a_step_does_not_do_is_no_part_of_the_mean():
    """Of (B_n) every fourth step projects: its iterations are averaged over these, not over all."""
    schemes = [ExplicitProjectionEuler(skip=3), ExplicitProjectionEuler()]
    levels = verify(schemes, [pendulum], "drift", paths=40, levels=3, block=40).levels
    means = levels.groupby("scheme")["mean_projection_iterations"].min()

    assert (means >= 1.0).all()


@pytest.mark.long
def test_a_cost_that_no_step_has_is_no_number():
    """Where fewer steps are made than are skipped, nothing was counted."""
    levels = verify([ExplicitProjectionEuler(skip=20)], [pendulum], "drift", paths=40, levels=3, block=40).levels

    assert levels[levels.h == levels.h.max()]["mean_projection_iterations"].isna().all()
    assert levels[levels.h == levels.h.min()]["mean_projection_iterations"].notna().all()
