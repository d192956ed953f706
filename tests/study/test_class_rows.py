"""Order conditions in a run: rows of claims about classes of SDEs, by whatever workers, and what becomes of them."""

from concurrent.futures import ThreadPoolExecutor
from typing import ClassVar

import pytest

from facade import (
    CLASS_COLUMNS,
    HERE,
    CellResult,
    EulerMaruyama,
    HalfExplicitEuler,
    Strong,
    Study,
    Workers,
    class_cells,
    class_of,
    class_results,
    class_rows,
    gbm,
    pendulum,
    plan,
    problem_spec,
    results_of_class,
)
from sdaeverify import Claim, Settings, verify
from sdaeverify.measuring import Finding, Verdict


class Promising(EulerMaruyama):
    """Claims too much where noise is not commutative, and nothing else."""

    name: ClassVar[str] = "promising"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=1.0, source="wishful thinking"),)


class Raising(EulerMaruyama):
    """Raises on more than one component."""

    name: ClassVar[str] = "raising"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        if len(state) > 1:
            raise ValueError("one component alone")
        return super().step(problem, state, t, h, noise)


def cells_of(*schemes):
    """Return the cells of some schemes on a problem."""
    return plan(schemes, [problem_spec(gbm)], [Strong()]).cells


def rows_of(cells, workers=HERE, verdict=Verdict.VERIFIED):
    """Return the rows on some cells with a verdict."""
    return class_rows([CellResult(cell, (Finding(quantity="x", verdict=verdict),)) for cell in cells], workers)


def told(rows, scheme, measure="strong"):
    """Return the verdicts of a scheme by class."""
    return {row.kind: row.verdict for row in rows if (row.scheme, row.measure) == (scheme, measure)}


def test_rows_are_those_of_the_measures_of_the_run():
    """A run of strong orders alone has no rows of weak ones, and says which condition refutes a claim."""
    rows = rows_of(cells_of(EulerMaruyama(), Promising()))

    assert {row.measure for row in rows} == {"strong"}
    assert set(told(rows, "euler-maruyama").values()) == {Verdict.VERIFIED}
    wrong = told(rows, "promising")
    assert wrong["additive"] == wrong["ode"] == Verdict.VERIFIED
    assert wrong["scalar"] == wrong["general"] == Verdict.REFUTED
    (row,) = (row for row in rows if (row.scheme, row.kind) == ("promising", "scalar"))
    assert row.why == "order 0.5: the condition b1(b1) fails, found 0, wanted I"


def test_rows_are_in_the_order_of_the_plan():
    """Whichever problem ends first: which one does is a matter of workers."""
    schemes = HalfExplicitEuler(), EulerMaruyama()
    for problems, first in (((gbm, pendulum), "euler-maruyama"), ((pendulum, gbm), "half-explicit-euler")):
        made = plan(schemes, [*map(problem_spec, problems)], [Strong()])
        study = Study(made, Settings(paths=40, block=40, levels=3), orders=True)
        assert list(study.run())
        assert study.class_rows[0].scheme == first


def test_workers_find_the_same():
    """Rows are the same whatever the workers, and a scheme that raises costs its own rows alone."""
    cells = cells_of(EulerMaruyama(), Raising())
    here = rows_of(cells)
    with ThreadPoolExecutor(2) as executor:
        there = rows_of(cells, Workers(executor, 2))

    assert [str(row.cells) for row in there] == [str(row.cells) for row in here]
    assert told(here, "raising")["general"] is Verdict.ERROR
    assert set(told(here, "euler-maruyama").values()) == {Verdict.VERIFIED}


def test_who_fails_everywhere_is_not_asked_again():
    """Of a scheme of which nothing could be measured there are no rows: what hangs would hang once more a class."""
    assert rows_of(cells_of(EulerMaruyama()), verdict=Verdict.ERROR) == ()


def test_results_of_classes_are_those_of_their_claims():
    """A claim that is decided for a class is a result of a cell that stands for it, asked alone or not."""
    cells = cells_of(Promising())
    results = list(class_results(rows_of(cells), cells))
    alone = {class_of(cell): results_of_class(cell) for cell in class_cells(cells)}

    assert [result.cell.spec.label for result in results[-1:]] == ["every-equation"]
    assert {class_of(each.cell): each.findings[0].verdict for each in results} == {
        kind: found[0].findings[0].verdict for kind, found in alone.items()
    }
    assert {Verdict.VERIFIED, Verdict.REFUTED} == {each.findings[0].verdict for each in results}


@pytest.fixture(scope="module")
def result():
    """Return a result without a folder."""
    return verify(Promising(), "gbm", "strong", paths=100)


def test_a_result_is_asked_for_its_classes(result):
    """They are found when they are read, with the columns that the dictionary explains."""
    classes = result.classes

    assert tuple(classes.columns) == tuple(column.name for column in CLASS_COLUMNS)
    assert set(classes["class"][classes.verdict == "refuted"]) >= {"scalar", "general"}
    assert classes.set_index("class").loc["scalar", "first"] == "b1(b1)"


@pytest.mark.long
def test_a_run_into_a_folder_has_the_same(result, tmp_path):
    """The table of a folder is that of the result."""
    saved = verify(Promising(), "gbm", "strong", paths=100, out=tmp_path)

    assert "details/classes.csv" in saved.tables
    assert saved.classes.equals(result.classes)
    assert (tmp_path / "details" / "classes.csv").is_file()
    # The label names the class unless it is the default one.
    labels = {f"every-equation[of={name}]" for name in saved.classes["class"]} - {"every-equation[of=general]"}
    assert set(saved.verdicts.problem) == {"gbm", "every-equation", *labels}
