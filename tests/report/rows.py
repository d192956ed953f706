"""Rows of tables as texts, as a folder of a run holds them."""

from sdaeverify.report.folders import SavedTables

VERDICT = {
    "scheme": "some-euler",
    "problem": "gbm",
    "measure": "strong",
    "quantity": "x",
    "claim": "order >= 0.5",
    "estimate": "0.392",
    "ci_low": "0.357",
    "ci_high": "0.428",
    "verdict": "verified",
    "reason": "local order 0.480",
    "method": "local order (T1), guarded by paths, exact solution",
    "paths": "256",
    "seconds": "0.1",
    "seed": "1",
    "reproduce": "python -m sdaeverify matrix -s some-euler -p gbm -m strong",
    "view": "",
    "confidence": "0.99",
    "margin": "0.2",
    "claim_source": "a book",
    "tier": "T1",
    "local_order": "0.48",
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
    "seed": "1",
    "fitted": "True",
}
RUN = {
    "arguments": ["sdaeverify", "matrix"],
    "seed": 1,
    "settings": {"confidence": 0.99, "steps": [8, 16], "paths": 256, "looks": 6, "family": 1000},
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
        "method": "successive differences along paths (T3)",
        "tier": "T3",
        "verdict": "out_of_scope",
        "claim": "",
        "margin": "",
        "estimate": "-14.05",
        "ci_low": "-22.17",
        "ci_high": "-5.93",
        "local_order": "",
        "local_weak_order": "0.9988",
        "path_order": "-14.05",
        "path_low": "-22.17",
        "path_high": "-5.93",
        "resolved": "0.2",
        "informative": "False",
    }
    return verdict(**{**told, **changed})


def level(**changed):
    """Return a row of the levels with some cells changed."""
    return {**LEVEL, **changed}


def tables(verdicts, levels=(), run=RUN, folder=None):
    """Return the tables of a run."""
    return SavedTables(folder, list(verdicts), list(levels), dict(run))
