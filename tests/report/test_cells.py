"""The cells of a table are read as they are written."""

import pandas as pd
import pytest

from sdaeverify.report.cells import text


@pytest.mark.parametrize(("held", "told"), [(None, ""), (float("nan"), ""), (pd.NA, ""), (True, "True"), ("a", "a")])
def test_what_holds_nothing_is_empty(held, told):
    """No value, NaN and the NA of nullable columns all read as an empty text."""
    assert text({"fitted": held}, "fitted") == told
