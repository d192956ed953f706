"""A scheme's run on a trivial equation, driven by given noise."""

from collections.abc import Iterator, Sequence

from ..arrays import Parts
from ..contracts.scheme import Scheme
from ..forms import Problem
from ..noise.brownian import Increment
from .batches import frozen


def parts_along(scheme: Scheme, problem: Problem, h: float, noises: Sequence[Increment]) -> Iterator[Parts]:
    """Yield the comparable components after each step of size h.

    Parameters
    ----------
    scheme : Scheme
    problem : Problem
        Of the scheme's form.
    h : float
    noises : sequence of Increment, dW of shape (l, P)
        With the scheme's law, one for each step.

    Yields
    ------
    mapping of str to ndarray
    """
    paths = noises[0].dW.shape[-1]
    state, stepper, recall = scheme.start(problem, paths, h), scheme.prepare(problem, h), problem.recall(h, paths)
    for n, drawn in enumerate(noises):
        noise = frozen(drawn if recall is None else recall.driven(drawn))
        state = stepper(frozen(state), n * h, noise).state
        parts = scheme.parts(problem, state)
        if recall is not None:
            recall.push(parts["x"])
        yield parts
