"""The conformance kit and the claims of the plugin."""

from sdaeverify_geodesic.ellipse_langevin import ellipse_langevin
from sdaeverify_geodesic.geodesic_baoab import GeodesicBAOAB

from sdaeverify.testing import parametrize_with_checks, parametrize_with_claims


@parametrize_with_checks([GeodesicBAOAB(), ellipse_langevin], problems=[ellipse_langevin])
def test_contract(subject, check):
    """Scheme and problem pass the conformance kit."""
    check(subject)


@parametrize_with_claims([GeodesicBAOAB()], problems=["ellipse-langevin"])
def test_claim(subject, check):
    """No claim is refuted on the ellipse."""
    check(subject)
