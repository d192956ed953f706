"""Parts of a run, made anywhere and merged."""

import pandas as pd
import pytest

pytestmark = pytest.mark.long

ASKED = ["-s", "milstein,heun", "-p", "gbm,gbm[a=1],gbm-algebraic", "-m", "strong,drift"]
BUDGET = ["--paths", "80", "--levels", "3", "-j", "1", "--timeout", "0", "--memory", "0", "--progress", "none"]


def test_shards_merge_to_one_run(call, tmp_path):
    """Three shards hold each pair once, and merge to the rows of one run, in their order and to the same bits."""
    shards = [tmp_path / f"shard{number}" for number in (3, 1, 2)]
    whole, merged = tmp_path / "whole", tmp_path / "merged"
    for folder in shards:
        assert call("matrix", *ASKED, *BUDGET, "--shard", f"{folder.name[-1]}/3", "--out", str(folder)).code == 0
    assert call("matrix", *ASKED, *BUDGET, "--out", str(whole)).code == 0

    assert call("merge", *map(str, shards), "--out", str(merged)).code == 0

    parts = [pd.read_csv(f / "verdicts.csv")[["scheme", "problem"]].drop_duplicates() for f in shards]
    parts = [part[~part.problem.str.startswith("every-equation")] for part in parts]
    assert [len(part) for part in parts] == [2, 2, 2]
    assert len(pd.concat(parts).drop_duplicates()) == 6
    for name in ("verdicts.csv", "levels.csv", "not_applicable.csv", "details/classes.csv"):
        one, other = (pd.read_csv(folder / name, dtype=str, keep_default_na=False) for folder in (whole, merged))
        assert len(one)
        pd.testing.assert_frame_equal(one, other[list(one)], check_exact=True)


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "a/b", "1/0", "-1/3"])
def test_no_shard(call, tmp_path, text):
    """A part that is none is told in one line."""
    outcome = call("matrix", *ASKED, *BUDGET, f"--shard={text}", "--out", str(tmp_path))

    assert outcome.code == 2
    assert "--shard expects I/N" in outcome.err
    assert outcome.err.count("\n") == 1
