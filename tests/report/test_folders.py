"""A folder is one run: what is saved replaces what was there."""

import json

import pandas as pd

from facade import RUN, save_tables
from facade import folders_LEVELS as LEVELS
from facade import folders_VERDICTS as VERDICTS


def test_tables_of_another_run_are_replaced(tmp_path):
    """Of details, those of measures that the run is not about are removed."""
    one = pd.DataFrame({"scheme": ["a"], "measure": ["m"]})
    save_tables(tmp_path, {VERDICTS: one, LEVELS: one, "details/m.csv": one}, {"seed": 1})
    two = pd.DataFrame({"scheme": ["b"], "measure": ["n"]})
    save_tables(tmp_path, {VERDICTS: two, LEVELS: two, "details/n.csv": two}, {"seed": 2})

    assert (tmp_path / VERDICTS).read_text() == (tmp_path / LEVELS).read_text() == "scheme,measure\nb,n\n"
    assert [file.name for file in (tmp_path / "details").glob("*.csv")] == ["n.csv"]
    assert json.loads((tmp_path / RUN).read_text()) == {"seed": 2}
