"""A volatility that grows linearly in time, with its integrals over a step."""

from dataclasses import dataclass

from sdaeverify import Array, Increment


@dataclass(frozen=True)
class GrowingVolatility:
    """The volatility b(t) = b (1 + growth t).

    Attributes
    ----------
    b : float
        Volatility at the start, unit 1/sqrt(time).
    growth : float
        Relative growth rate, unit 1/time.
    """

    b: float
    growth: float

    def __call__(self, t: float) -> float:
        """Return b(t)."""
        return self.b * (1.0 + self.growth * t)

    def variance(self, t: float, h: float) -> float:
        """Return int_t^{t+h} b(s)^2 ds, by Simpson's rule, which is exact for the square of a linear function."""
        begin, middle, end = (self(t + part * h) ** 2 for part in (0.0, 0.5, 1.0))
        return h * (begin + 4.0 * middle + end) / 6.0

    def integral(self, t: float, h: float, noise: Increment) -> Array:
        """Return int_t^{t+h} b dW = b(t + h) dW - b growth int_t^{t+h} (W(s) - W(t)) ds, shape (1, P)."""
        return self(t + h) * noise.dW - self.b * self.growth * noise.time_integral(h)
