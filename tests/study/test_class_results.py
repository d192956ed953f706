"""Claims about classes of equations in a run: results of the tests of plugins, by whatever workers."""

import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from importlib.metadata import EntryPoint
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
    Weak,
    Workers,
    class_cells,
    class_results,
    class_tests,
    gbm,
    pendulum,
    plan,
    problem_spec,
    results_of_class,
)
from sdaeverify import Claim, Settings, UsageError, verify
from sdaeverify.errors import PluginError
from sdaeverify.measuring import Finding, Method, Verdict
from sdaeverify.studying import ClassTests


class Promising(EulerMaruyama):
    """Claims too much where noise is not commutative, and nothing else."""

    name: ClassVar[str] = "promising"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=1.0, source="wishful thinking"),)


class Hasty(EulerMaruyama):
    """Claims weak order 2, and nothing else."""

    name: ClassVar[str] = "hasty"
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=2.0, source="wishful thinking"),)


class Raising(EulerMaruyama):
    """Raises on more than one component."""

    name: ClassVar[str] = "raising"

    def step(self, problem, state, t, h, noise):
        """Make one step."""
        if len(state) > 1:
            raise ValueError("one component alone")
        return super().step(problem, state, t, h, noise)


def cells_of(*schemes, measure=Strong):
    """Return the cells of some schemes on a problem."""
    return plan(schemes, [problem_spec(gbm)], [measure()]).cells


def rows_of(cells, workers=HERE, verdict=Verdict.VERIFIED, **asked):
    """Return the results about classes, given a verdict on some cells."""
    results = [CellResult(cell, (Finding(quantity="x", verdict=verdict),)) for cell in cells]
    return class_results(results, workers, **asked)


def parts(result):
    """Return the label of the scheme, the class, the measure and the finding of a result."""
    (finding,) = result.findings
    return result.cell.scheme.label, result.cell.class_name, result.cell.measure.name, finding


def compared(result):
    """Return the parts of a result as objects that are equal if they have the same content.

    NaN equals nothing, so a finding is a text; the text of a set may change when it is pickled, so a claim is not.
    """
    *names, finding = parts(result)
    return *names, str(replace(finding, claim=None)), finding.claim


def told(rows, scheme, measure="strong"):
    """Return the verdicts of a scheme by class."""
    return {
        kind: found.verdict for label, kind, name, found in map(parts, rows) if (label, name) == (scheme, measure)
    }


def test_rows_are_those_of_the_measures_of_the_run():
    """A run of strong orders alone has no rows of weak ones, and says which condition refutes a claim."""
    rows = rows_of(cells_of(EulerMaruyama(), Promising()))

    assert {row.cell.measure.name for row in rows} == {"strong"}
    assert set(told(rows, "euler-maruyama").values()) == {Verdict.VERIFIED}
    wrong = told(rows, "promising")
    assert wrong["additive"] == wrong["ode"] == Verdict.VERIFIED
    assert wrong["scalar"] == wrong["general"] == Verdict.REFUTED
    (found,) = (found for *names, found in map(parts, rows) if names == ["promising", "scalar", "strong"])
    named = "Milstein's correction, the sum of DB_k B_j I_jk, is left out"
    assert str(found.reason) == f"{named}; order 0.5: the condition b1(b1) fails, found 0, wanted I"


@pytest.mark.long
def test_rows_are_in_the_order_of_the_plan():
    """Whichever problem ends first: which one does is a matter of workers."""
    schemes = HalfExplicitEuler(), EulerMaruyama()
    for problems, first in (((gbm, pendulum), "euler-maruyama"), ((pendulum, gbm), "half-explicit-euler")):
        made = plan(schemes, [*map(problem_spec, problems)], [Strong()])
        study = Study(made, Settings(paths=40, block=40, levels=3), orders=True)
        assert list(study.run())
        assert study.class_results[0].cell.scheme.label == first


def test_workers_find_the_same():
    """Rows are the same whatever the workers, and a scheme that raises costs its own rows alone."""
    cells = cells_of(EulerMaruyama(), Raising())
    here = rows_of(cells)
    with ThreadPoolExecutor(2) as executor:
        there = rows_of(cells, Workers(executor, 2))

    assert [compared(row) for row in there] == [compared(row) for row in here]
    assert told(here, "raising")["general"] is Verdict.ERROR
    assert set(told(here, "euler-maruyama").values()) == {Verdict.VERIFIED}


class Prepared(Raising):
    """Raises in the function that it prepares."""

    name: ClassVar[str] = "prepared"

    def prepare(self, problem, h):
        """Return a step without the framework between it and its caller."""
        return lambda state, t, noise: self.step(problem, state, t, h, noise)


def test_an_error_names_the_line_of_the_scheme():
    """Neither a line of the test that called it, nor of what called that."""
    rows = rows_of(cells_of(Prepared()))
    reasons = {str(found.reason) for *_, found in map(parts, rows) if found.verdict is Verdict.ERROR}

    assert len(reasons) == 1
    assert re.fullmatch(r"ValueError: one component alone \(tests/study/test_class_results\.py:\d+\)", *reasons)


def test_who_fails_everywhere_is_not_asked_again():
    """Of a scheme of which nothing could be measured there are no rows: what hangs would hang once more a class."""
    assert rows_of(cells_of(EulerMaruyama()), verdict=Verdict.ERROR) == ()


def test_results_of_classes_are_those_of_their_claims():
    """A claim that is decided for a class is a result of a cell that stands for it, asked alone or not."""
    cells = cells_of(Promising())
    results = rows_of(cells)
    alone = {cell.class_name: results_of_class(cell) for cell in class_cells(cells)}

    assert [result.cell.spec.label for result in results[-1:]] == ["every-equation"]
    assert {each.cell.class_name: each.findings[0].verdict for each in results} == {
        kind: found[0].findings[0].verdict for kind, found in alone.items()
    }
    assert {Verdict.VERIFIED, Verdict.REFUTED} == {each.findings[0].verdict for each in results}


@pytest.mark.long
def test_a_refuted_weak_order_has_the_modified_equation():
    """A run computes it for what is refuted alone, and for right schemes where it is asked for."""
    cells = cells_of(EulerMaruyama(), Hasty(), measure=Weak)
    kinds = {(label, kind): found for label, kind, _, found in map(parts, rows_of(cells))}
    asked = {(label, kind): found.details for label, kind, _, found in map(parts, rows_of(cells, modified=True))}

    wrong, right = kinds["hasty", "additive"], kinds["euler-maruyama", "additive"]
    assert (wrong.verdict, right.verdict) == (Verdict.REFUTED, Verdict.VERIFIED)
    assert "f + h (-1/4 sum_j f''[b_j, b_j]" in wrong.details["modified"]
    assert "f(b1,b1): -1/4 sum_j f''[b_j, b_j]" in wrong.details["modified_terms"].split("\n")
    assert (right.details["modified"], right.details["modified_terms"]) == ("", "")
    assert asked["euler-maruyama", "additive"]["modified_terms"] == wrong.details["modified_terms"]
    assert "no modified SDE at h" in asked["euler-maruyama", "scalar"]["modified"]


def test_a_refuted_strong_order_has_no_modified_equation():
    """The equation is one of means, which do not tell why paths are wrong."""
    found = [parts(row)[-1].details for row in rows_of(cells_of(Promising()))]
    assert found
    assert not [each for each in found if each["modified"]]


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


class Named(str):
    """A class that is nothing but its name."""

    __slots__ = ()

    @property
    def name(self):
        """Return the name."""
        return str(self)


class Own(ClassTests):
    """Tests of somebody else: every claim is verified for one class, and the other one raises."""

    def classes(self, entry, seed):
        """Return two classes."""
        return [Named("good"), Named("bad")]

    def claimed(self, entry, seed):
        """Return the same."""
        return self.classes(entry, seed)

    def findings(self, entry, kind, seed, *, modified=False):
        """Yield a finding for each measure there is, asked for or not."""
        if kind == "bad":
            raise ValueError("none")
        for measure in ("strong", "weak", "made-up"):
            yield measure, Finding(quantity="by hand", verdict=Verdict.VERIFIED, method=Method("by hand"))

    def failed(self, entry, kind, why):
        """Return an error."""
        return [("strong", Finding(quantity="", verdict=Verdict.ERROR, reason=why))]


def test_tests_of_somebody_else_have_results_of_cells():
    """They are those of the measures of the run, in the tier of conditions, and what raises is an error."""
    good, bad = rows_of(cells_of(EulerMaruyama()), tests=[Own()])

    assert [parts(each)[:3] for each in (good, bad)] == [
        ("euler-maruyama", kind, "strong") for kind in ("good", "bad")
    ]
    assert (good.cell.spec.label, str(good.findings[0].method)) == ("every-equation[of=good]", "by hand (TA)")
    assert bad.findings[0].verdict is Verdict.ERROR
    assert str(bad.findings[0].reason).startswith("ValueError: none")


class Nameless(Own):
    """Tests whose plugin raises as it names the classes."""

    def classes(self, entry, seed):
        """Raise."""
        raise KeyError(entry.scheme.name)


def test_classes_that_cannot_be_named_are_errors():
    """A plugin that raises as it names classes costs rows of its own, and not those of another plugin."""
    lost, good, _ = rows_of(cells_of(EulerMaruyama()), tests=[Nameless(), Own()])

    assert parts(good)[1] == "good"
    assert lost.findings[0].verdict is Verdict.ERROR
    assert str(lost.findings[0].reason).startswith(f"Nameless.classes of {__name__}: KeyError: 'euler-maruyama'")


def test_a_class_is_no_problem():
    """The specification of its cells stands for all equations, and none can be built from it."""
    (cell, *_) = class_cells(cells_of(Promising()))

    assert cell.class_name == "ode"
    with pytest.raises(UsageError, match="a class of equations is not a problem: 'ode' cannot be built"):
        cell.spec.build()


def test_without_tests_there_are_no_results(monkeypatch):
    """Disabled tests are not asked, and a result says that there are none."""
    monkeypatch.setenv("SDAEVERIFY_DISABLED_PLUGINS", "orders")

    assert class_tests() == ()
    assert rows_of(cells_of(EulerMaruyama())) == ()
    with pytest.raises(UsageError, match="this installation has no tests of claims about classes of equations"):
        _ = verify(Promising(), "gbm", "strong", paths=64).classes


BROKEN = {"sdaeverify_nowhere:TESTS": "No module named", "sdaeverify:verify": "expected ClassTests, got function"}


@pytest.fixture(params=BROKEN)
def odd(request, monkeypatch):
    """Install broken tests of classes beside the shipped ones; return why they are broken."""
    places = {"odd": request.param, "orders": "sdaeverify_orders.order_tests:ORDER_TESTS"}
    known = [EntryPoint(name, place, "sdaeverify.classes") for name, place in places.items()]
    monkeypatch.setattr("sdaeverify.study.class_tests.enabled_entry_points", lambda _: known)
    return BROKEN[request.param]


@pytest.mark.sweep
def test_broken_tests_are_left_out(odd, tmp_path, caplog):
    """A warning names the plugin, and the claims are tested by those of the others."""
    found = verify(Promising(), "gbm", "strong", paths=64, out=tmp_path)

    (warning,) = [line for line in caplog.messages if "class test" in line]
    assert warning.startswith("the class test of plugin odd ")
    assert odd in warning
    assert warning.endswith("; claims about its classes are not tested")
    assert set(found.classes["class"]) >= {"ode"}


def test_strict_environment_refuses_broken_tests(odd, monkeypatch):
    """The run ends before it begins."""
    monkeypatch.setenv("SDAEVERIFY_STRICT_PLUGINS", "1")

    with pytest.raises(PluginError, match=rf"the class test of plugin odd .*{odd}"):
        Study(plan([EulerMaruyama()], [problem_spec(gbm)], [Strong()]), Settings(), orders=True)
