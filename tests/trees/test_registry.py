"""What order conditions say of every shipped scheme, for every class that it accepts."""

import pytest

from facade import CLASSES, load_registry, rows_of_classes
from sdaeverify import SDE, IndexOneSDAE, Langevin

FORMS = (SDE, Langevin, IndexOneSDAE)
OWN = [scheme for entry in load_registry(()).schemes.values() for scheme in entry.things]
SCHEMES = {
    scheme.label: scheme
    for scheme in OWN
    if type(scheme).__module__.startswith("sdaeverify_schemes.")
    and any(issubclass(each, scheme.forms) for each in FORMS)
}
SAID = {"verified", "inconclusive", "out_of_scope", "not_applicable"}


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(SCHEMES))
def test_a_shipped_scheme_is_verified_or_a_premise_fails(name):
    """No claim is refuted or in error, and where one is verified the order found is at least the one claimed."""
    rows = list(rows_of_classes(SCHEMES[name], CLASSES, 2))

    assert {row.verdict for row in rows} <= SAID, [row for row in rows if row.verdict not in SAID]
    assert all(row.order >= row.claim for row in rows if row.verdict == "verified")
