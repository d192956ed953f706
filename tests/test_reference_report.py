"""The committed report is that of the shipped matrix, as one command writes it."""

import json
from pathlib import Path

import pandas as pd
import pytest

from facade import load_registry, plan_of
from sdaeverify import Settings, verify
from sdaeverify.report.folders import read_verdicts

FOLDER = Path(__file__).parents[1] / "reports" / "reference"
CELL = ["scheme", "problem", "measure"]


@pytest.fixture(scope="module")
def verdicts():
    """Return the committed verdicts on problems."""
    rows = pd.read_csv(FOLDER / "verdicts.csv")
    return rows[~rows.problem.str.startswith("every-equation")]


def test_report_covers_the_shipped_matrix(verdicts):
    """Every shipped scheme, problem and measure is in it, and nothing else: libraries have their own report."""
    registry = load_registry(environ={})
    own = [scheme for entry in registry.schemes.values() for scheme in entry.variants if not scheme.claimant]
    plan = plan_of(registry, own, (), ())
    rows = pd.concat([verdicts, pd.DataFrame(read_verdicts(FOLDER).absent)])

    assert set(rows[CELL].itertuples(index=False, name=None)) == {
        (cell.scheme.label, cell.spec.label, cell.measure.name) for cell in plan.cells
    }


def test_report_is_at_the_default_settings(verdicts):
    """Seed and number of paths are the defaults: the command needs no options."""
    settings = Settings()
    assert json.loads((FOLDER / "run.json").read_text())["settings"]["seed"] == settings.seed
    looks = {sum(settings.paths_of(block) for block in range(end)) for end in settings.ends}
    assert set(verdicts.paths) <= looks


def test_a_cell_of_the_report_can_be_computed_again(verdicts):
    """A cell gives the committed estimates, up to what another build's exp may change."""
    again = verify("milstein", "gbm", "strong").verdicts.set_index("quantity")
    of_cell = (verdicts.scheme == "milstein") & (verdicts.problem == "gbm") & (verdicts.measure == "strong")
    committed = verdicts[of_cell].set_index("quantity")

    assert again.path_order.to_dict() == pytest.approx(committed.path_order.to_dict(), rel=1e-6)
