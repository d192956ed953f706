"""What tests of adaptive solvers share: problems, solvers, and the verdicts of one alone."""

from functools import cache

from facade import load_registry
from sdaeverify.studying import Source, select_problems
from sdaeverify_adaptive import brownian_path
from sdaeverify_adaptive.judging import Question, ask
from sdaeverify_adaptive.sample import Budget, measure
from sdaeverify_solvers import judge

GBM = "gbm[a=0.1,b=0.8]"


@cache
def registry():
    return load_registry(environ={}, lab=True)


@cache
def problem(label):
    return select_problems(registry(), label)[0].build()


def solver(name):
    return registry().things("sdaeverify_adaptive")[name]


def path(l=1, paths=20, seed=1, label="a path", horizon=1.0):
    return brownian_path(Source(seed, label, 0, paths), l, horizon)


def sample(name, label, paths=400, seed=1, tolerances=()):
    return measure(solver(name), problem(label), Budget(paths, tolerances, seed), label)


def findings(measured, *, with_limit=True):
    """Return the findings on a solver by measure and quantity, it being judged alone."""
    asked = list(ask(Question(measured, with_limit)))
    return {(each.measure, each.covered.quantity): one for each, one in zip(asked, judge(asked), strict=True)}


def verdicts(measured, *, with_limit=True):
    return {key: one.verdict.value for key, one in findings(measured, with_limit=with_limit).items()}
