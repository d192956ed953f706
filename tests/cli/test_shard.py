"""Parts of a run, made anywhere and merged."""

import pandas as pd
import pytest

ASKED = ["-s", "euler-maruyama,milstein,heun", "-p", "gbm,ou", "-m", "strong"]
BUDGET = ["--paths", "512", "--levels", "3", "-j", "1", "--timeout", "0", "--memory", "0", "--progress", "none"]


def table(folder, name):
    """Return a table of a run, whatever the order of its rows."""
    found = pd.read_csv(folder / name, dtype=str, keep_default_na=False)
    keys = [key for key in ("scheme", "problem", "measure", "quantity", "h") if key in found]
    return found.sort_values(keys, ignore_index=True)[sorted(found)]


def test_shards_merge_to_one_run(call, tmp_path):
    """Three shards hold each pair once, and merge to the same bits as one run."""
    shards = [tmp_path / f"shard{number}" for number in (1, 2, 3)]
    whole, merged = tmp_path / "whole", tmp_path / "merged"
    for number, folder in enumerate(shards, start=1):
        assert call("matrix", *ASKED, *BUDGET, "--shard", f"{number}/3", "--out", str(folder)).code == 0
    assert call("matrix", *ASKED, *BUDGET, "--out", str(whole)).code == 0

    assert call("merge", *map(str, shards), "--out", str(merged)).code == 0

    pairs = [set(map(tuple, table(f, "verdicts.csv")[["scheme", "problem"]].to_numpy())) for f in shards]
    assert [len(part) for part in pairs] == [2, 2, 2]
    assert len(set.union(*pairs)) == 6
    for name in ("verdicts.csv", "levels.csv"):
        pd.testing.assert_frame_equal(table(whole, name), table(merged, name), check_exact=True)


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "a/b", "1/0", "-1/3"])
def test_no_shard(call, tmp_path, text):
    """A part that is none is told in one line."""
    outcome = call("matrix", *ASKED, *BUDGET, f"--shard={text}", "--out", str(tmp_path))

    assert outcome.code == 2
    assert "--shard expects I/N" in outcome.err
    assert outcome.err.count("\n") == 1


def test_merged_rows_are_in_the_order_of_one_run(call, tmp_path):
    """Whatever their labels are, no row changes its place, of what applies and of what does not."""
    asked = ["-s", "milstein,heun", "-p", "gbm,gbm[a=1],gbm-algebraic", "-m", "strong,drift"]
    budget = ["--paths", "80", *BUDGET[2:]]
    for out, more in (("whole", []), ("one", ["--shard", "1/2"]), ("other", ["--shard", "2/2"])):
        call("matrix", *asked, *budget, *more, "--out", str(tmp_path / out))

    call("merge", str(tmp_path / "other"), str(tmp_path / "one"), "--out", str(tmp_path / "merged"))

    for name in ("verdicts.csv", "not_applicable.csv"):
        whole, merged = (pd.read_csv(tmp_path / folder / name, usecols=[0, 1, 2]) for folder in ("whole", "merged"))
        assert len(whole)
        pd.testing.assert_frame_equal(whole, merged)
