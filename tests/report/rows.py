"""Rows of tables as texts, as a folder of a run holds them."""

from facade import VERDICTS, SavedTables, VerdictRow, names

VERDICT = {
    **dict.fromkeys(names(VERDICTS), ""),
    "scheme": "some-euler",
    "problem": "gbm",
    "measure": "strong",
    "quantity": "x",
    "verdict": "verified",
    "claim": "order >= 0.5",
    "claimed_order": "0.5",
    "margin": "0.2",
    "local_order": "0.48",
    "path_order": "0.392",
    "path_low": "0.357",
    "path_high": "0.428",
    "decided_by": "T1",
    "guarded_by": "paths, exact solution",
    "reason": "local order 0.480",
    "p_refuted": "1.0",
    "paths": "256",
}
DETAIL = {
    "scheme": "some-euler",
    "problem": "gbm",
    "measure": "strong",
    "quantity": "x",
    "method": "local order (T1), guarded by paths, exact solution",
    "claim_source": "a book",
    "seconds": "0.1",
}
LEVEL = {
    "scheme": "some-euler",
    "problem": "gbm",
    "measure": "strong",
    "quantity": "x",
    "h": "0.125",
    "estimate": "0.01",
    "std_error": "0.001",
    "paths": "256",
    "failed_paths": "0",
    "truncated_share": "0.0",
    "steps": "8",
    "lost_paths": "0",
    "fitted": "True",
}
RUN = {
    "schema_version": 2,
    "arguments": ["sdaeverify", "matrix"],
    "seed": 1,
    "settings": {
        "paths": 256,
        "coarsest": 8,
        "levels": 3,
        "seed": 1,
        "confidence": 0.99,
        "block": 4096,
        "max_looks": 6,
        "tests_reserved": 1000,
        "steps": [8, 16, 32],
    },
    "versions": {"python": "3.11"},
    "platform": {"system": "here"},
}


def verdict(**changed):
    """Return a row of the verdicts with some cells changed."""
    return {**VERDICT, **changed}


def weak(**changed):
    """Return a row on an observable whose paths tell no order."""
    told = {
        "measure": "weak",
        "quantity": "v_1",
        "verdict": "out_of_scope",
        **dict.fromkeys(("claim", "margin", "path_order", "path_low", "path_high", "decided_by", "guarded_by"), ""),
        "local_order": "0.9988",
        "reason": "nothing is claimed; no order along paths: a mean difference is 0.2 standard errors",
        "reason_kind": "no claim",
    }
    return verdict(**{**told, **changed})


def read(*rows):
    """Return rows of texts as they are read."""
    return [VerdictRow.from_row(row) for row in rows]


def detail(**changed):
    """Return a row of the details of a measure with some cells changed."""
    return {**DETAIL, **changed}


def level(**changed):
    """Return a row of the levels with some cells changed."""
    return {**LEVEL, **changed}


def tables(verdicts, levels=(), run=RUN, folder=None, absent=()):
    """Return the tables of a run."""
    rows = list(verdicts)
    names = ("scheme", "problem", "measure", "quantity")
    details = [detail(**{name: row[name] for name in names}) for row in rows]
    return SavedTables(folder, rows, list(absent), dict(run), list(levels), details)
