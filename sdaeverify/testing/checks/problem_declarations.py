"""Checks of what a problem says of itself."""

import pickle

import numpy as np

from ...contracts.labels import parse_label
from ...contracts.specs import check_family, problem_spec
from ...errors import SdaeverifyError
from ...forms.truths import InvariantMean
from ..problem_subject import ProblemSubject


def usable(subject: ProblemSubject) -> str:
    """Expect a function with a name, and with parameters whose defaults a label can show."""
    try:
        check_family(subject.spec.family)
    except SdaeverifyError as error:
        return str(error)
    return ""


def built(subject: ProblemSubject) -> str:
    """Expect the function to return a problem that does not contradict itself."""
    try:
        subject.spec.build()
    except SdaeverifyError as error:
        return str(error)
    return ""


def named_again(subject: ProblemSubject) -> str:
    """Expect the label to make the problem again: the command that reproduces a result has nothing else."""
    spec = subject.spec
    again = problem_spec(spec.family, parse_label(spec.label).parameters)
    return "" if again == spec else f"its label {spec.label} makes another problem, {again.label}"


def pickled(subject: ProblemSubject) -> str:
    """Expect the function to be pickled by its name: that is how worker processes get it."""
    spec = subject.spec
    return "" if pickle.loads(pickle.dumps(spec)) == spec else "its pickled copy is another recipe"


def described(subject: ProblemSubject) -> str:
    """Expect a docstring: a list of problems shows its first line."""
    return "" if (subject.spec.family.__doc__ or "").strip() else "its function has no docstring"


def sourced(subject: ProblemSubject) -> str:
    """Expect sources of the problem and of each truth, and units."""
    problem = subject.problem
    if missing := [name for name in ("source", "units") if not getattr(problem, name).strip()]:
        return f"its {' and '.join(missing)} is empty"
    silent = [type(truth).__name__ for truth in problem.truths if not truth.source.strip()]
    return f"a {silent[0]} among its truths has no source" if silent else ""


def marked(subject: ProblemSubject) -> str:
    """Expect the mark of a long problem to be that of `on_request`, which a run of everything heeds."""
    mark = getattr(subject.spec.family, "on_request", False)
    return "" if isinstance(mark, bool) else f"its mark on_request is {mark!r}; put @on_request above the function"


def relaxing(subject: ProblemSubject) -> str:
    """Expect a relaxation time exactly where an invariant law is known: chains are run as long as it says."""
    problem = subject.problem
    known = any(isinstance(truth, InvariantMean) for truth in problem.truths)
    if not problem.relaxation > 0.0:
        return f"its relaxation time is {problem.relaxation!r}, expected a positive time"
    if known and not np.isfinite(problem.relaxation):
        return "it knows invariant means, but no relaxation time"
    if not known and np.isfinite(problem.relaxation):
        return "it has a relaxation time, but knows no invariant mean"
    return ""
