"""Numbers as text: fractions and square roots if a decimal is near enough to one, else decimals with an error.

A number is identified with an exact one only if fewer than one random number in a hundred would be as near to one of
the candidates: fractions with denominators up to D cover 0.6 D^2 times the error of the unit interval.
"""

from fractions import Fraction
from functools import lru_cache
from math import floor, isqrt, log10, sqrt

MOST, CHANCE = 1000, 0.01
# (a + b sqrt(n))/d with d up to 24 and |b| up to d: 0.4 million numbers on an interval of length 10.
ROOTS, ROOT_DENOMINATORS, LARGEST, ROOT_ERROR = (2, 3, 5, 6), 24, 5.0, 1e-7


def recognised(value: float, error: float) -> tuple[Fraction, Fraction, int] | None:
    """Return (a, b, n) with a + b sqrt(n) near a number, where n = 1 and b = 0 for a fraction, or None.

    Parameters
    ----------
    value : float
    error : float
        Bound on the error of the value.
    """
    most = min(MOST, isqrt(int(CHANCE / (0.6 * error)))) if error > 0.0 else MOST
    near = Fraction(value).limit_denominator(max(most, 1))
    if most and abs(float(near) - value) <= error:
        return near, Fraction(0), 1
    return _with_root(value, error) if error <= ROOT_ERROR and abs(value) <= LARGEST else None


def _with_root(value: float, error: float) -> tuple[Fraction, Fraction, int] | None:
    for n in ROOTS:
        for b in _parts():
            a = Fraction(value - float(b) * sqrt(n)).limit_denominator(ROOT_DENOMINATORS)
            if abs(float(a) + float(b) * sqrt(n) - value) <= error:
                return a, b, n
    return None


@lru_cache(maxsize=1)
def _parts() -> tuple[Fraction, ...]:
    found = {Fraction(a, d) for d in range(1, ROOT_DENOMINATORS + 1) for a in range(-d, d + 1) if a}
    return tuple(sorted(found, key=lambda each: (each.denominator, abs(each), each)))


def number_words(value: float, error: float) -> str:
    """Return a number as text: ``1/12``, ``(1/2 - 1/3 sqrt(3))``, or ``0.1234(2)`` with the error of the last digit.

    Parameters
    ----------
    value : float
    error : float
        Bound on the error of the value.
    """
    exact = recognised(value, error)
    if exact is None:
        digits = max(0, -floor(log10(error))) if error > 0.0 else 12
        return f"{value:.{digits}f}({max(1, round(error * 10.0**digits))})"
    a, b, n = exact
    if not b:
        return str(a)
    root = f"{'' if abs(b) == 1 else f'{abs(b)} '}sqrt({n})"
    if not a:
        return f"{'-' if b < 0 else ''}{root}"
    return f"({a} {'-' if b < 0 else '+'} {root})"
