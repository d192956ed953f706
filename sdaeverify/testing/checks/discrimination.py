"""Check of controls: two schemes that show whether a problem distinguishes orders."""

from collections.abc import Iterator
from dataclasses import replace

from ...contracts.finding import Finding, Verdict
from ...contracts.scheme import Claim, Scheme, with_claims
from ...contracts.settings import Settings
from ...forms.controls import Control
from ...registry.selection import select_measures, select_schemes
from ...study import CellResult, Plan, Study, plan
from ..check import Inapplicable
from ..subjects import ProblemSubject

# One step decides most orders, and paths only have to agree; this number of paths refutes no claim alone.
BUDGET = Settings(paths=256, max_looks=1)


def check_controls(subject: ProblemSubject) -> str:
    """Expect the positive control of each order to be verified, and the negative one to be refuted."""
    controls = subject.problem.controls
    if not controls:
        raise Inapplicable("it declares no controls")
    undecided = ""
    for measure in dict.fromkeys(control.measure for control in controls):
        for control, results in _judge(subject, measure, [each for each in controls if each.measure == measure]):
            if text := _find_contradiction(control, *results):
                return text
            undecided = undecided or _find_undecided(control, *results)
    if undecided:
        raise Inapplicable(f"{BUDGET.paths} paths do not decide: {undecided}")
    return ""


def _judge(
    subject: ProblemSubject, measure: str, controls: list[Control]
) -> Iterator[tuple[Control, tuple[CellResult, CellResult]]]:
    """Yield each control with the results of its two schemes, both of which claim its order."""
    (found,) = select_measures(subject.registry, [measure])
    schemes = [_claiming(subject, each, label) for each in controls for label in (each.positive, each.negative)]
    # Schemes and measures excluded from a default run of the problem can still be its controls.
    spec = replace(subject.spec, schemes=(), measures=())
    made = plan(schemes, [spec], [found], followed=subject.registry.followed)
    # The control schemes are judged here as ordinary schemes, so the plan has no controls.
    study = Study(Plan(tuple(replace(problem, controls=()) for problem in made.problems)), BUDGET)
    for _ in study.run():
        pass
    results = {id(result.cell.scheme): result for result in study.results()}
    for n, control in enumerate(controls):
        yield control, (results[id(schemes[2 * n])], results[id(schemes[2 * n + 1])])


def _claiming(subject: ProblemSubject, control: Control, label: str) -> Scheme:
    claim = Claim(measure=control.measure, value=control.order, source="control")
    return with_claims(select_schemes(subject.registry, label)[0], claim)


def _find_contradiction(control: Control, positive: CellResult, negative: CellResult) -> str:
    what, wrong = f"{control.measure} order {control.order:g}", {Verdict.ERROR, Verdict.DIVERGED}
    if found := _first_words(positive, {Verdict.REFUTED, *wrong}):
        return f"the positive control {control.positive} of {what} is not verified: {found}"
    if _absent(positive) != _absent(negative):
        return f"one of the controls {control.positive} and {control.negative} of {what} cannot be put to it"
    if (found := _first_words(negative, wrong)) or (found := _all_verified(negative)):
        return f"the negative control {control.negative} of {what} is not refuted: {found}"
    return ""


def _find_undecided(control: Control, positive: CellResult, negative: CellResult) -> str:
    if _absent(positive):
        return ""
    undecided = "" if _first_words(positive, {Verdict.VERIFIED}) else control.positive
    undecided = undecided or ("" if _first_words(negative, {Verdict.REFUTED}) else control.negative)
    return undecided and f"{undecided} as a control of {control.measure} order {control.order:g}"


def _absent(result: CellResult) -> bool:
    return all(finding.verdict is Verdict.NOT_APPLICABLE for finding in result.findings)


def _all_verified(result: CellResult) -> str:
    judged = [finding for finding in result.findings if finding.verdict is not Verdict.OUT_OF_SCOPE]
    verified = bool(judged) and all(finding.verdict is Verdict.VERIFIED for finding in judged)
    return _finding_words(judged[0]) if verified else ""


def _first_words(result: CellResult, verdicts: set[Verdict]) -> str:
    return next((_finding_words(finding) for finding in result.findings if finding.verdict in verdicts), "")


def _finding_words(finding: Finding) -> str:
    return f"{finding.quantity} {finding.verdict}, {finding.reason}".strip()
