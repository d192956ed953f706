"""What Euler's scheme with N steps is off from Euler's scheme with more steps on the same path, in closed form."""


def mean_square(a: float, b: float, steps: int, finer: int) -> float:
    """Return E (x_N - x_M)^2 on dx = a x dt + b x dW, x_0 = 1, T = 1: N = steps, M = N finer.

    Over a long step E x_N^2 grows by (1 + a h)^2 + b^2 h, E x_N x_M by (1 + a h) q^r + b^2 h q^(r-1) with
    q = 1 + a h/r, and E x_M^2 by (q^2 + b^2 h/r)^r.
    """
    h, r = 1.0 / steps, finer
    q = 1.0 + a * h / r
    own, fine = (1.0 + a * h) ** 2 + b * b * h, (q * q + b * b * h / r) ** r
    both = (1.0 + a * h) * q**r + b * b * h * q ** (r - 1)
    return own**steps - 2.0 * both**steps + fine**steps


def lines_of(run):
    """Return the lines of a table of means that has been run."""
    return run.plan.experiment.lines(run.evidence)
