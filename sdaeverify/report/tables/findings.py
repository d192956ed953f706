"""A finding as people are told of it: one meaning a field in every measure, and no order of noise."""

from math import inf, isfinite, isnan, nan

from ...contracts.finding import Finding, Reason
from ..reading import AT_END, BIAS, DECIDED, ORDER, RESIDUAL, Interval, Reading

GUARDED = "guarded by "
# Standard errors from which on a mean difference tells something.
RESOLVED = 3.0
SAMPLED, AT_ONCE, ONE_STEP, CONTRACT = 3, 2, 1, 0


def read_finding(found: Finding, value_of: str = "") -> Reading:
    """Read a finding.

    Parameters
    ----------
    found : Finding
    value_of : str
        What its measure estimates; empty for an order.
    """
    kind, claim = _kind(found, value_of), str(found.claim or "")
    path, why = _along_paths(found) if kind == ORDER else (Interval(), "")
    value, told = _value(found, kind, path)
    reason = found.reason.then(Reason(f"no order along paths: {why}" if why else ""))
    decided = found.method and found.verdict in DECIDED
    return Reading(
        claim=claim,
        margin=found.claim.margin if found.claim and claim.startswith(ORDER) else nan,
        local_order=_local_order(found, kind),
        path=path,
        value=value,
        value_of=told,
        verdict=str(found.verdict),
        decided_by=f"T{found.tier}" if decided or (found.method and found.tier == CONTRACT) else "",
        guarded_by=found.method.partition(GUARDED)[2] if decided else "",
        reason=str(reason),
        reason_kind=", ".join(found.reason.kinds),
    )


def _kind(found: Finding, value_of: str) -> str:
    if found.details.get("class") == BIAS or str(found.claim or "").startswith("unbiased"):
        return BIAS
    if found.method.startswith(RESIDUAL):
        return RESIDUAL
    return value_of or ORDER


def _detail(found: Finding, name: str) -> float:
    return float(str(found.details.get(name, nan)))


def _estimate(found: Finding) -> Interval:
    return Interval(found.estimate, found.low, found.high)


def _along_paths(found: Finding) -> tuple[Interval, str]:
    """Return the order along paths, and why there is none although paths were sampled."""
    told = "informative" in found.details
    sampled = found.method and (found.tier == SAMPLED or GUARDED in found.method)
    order = Interval(*(_detail(found, f"slope{end}") for end in ("", "_low", "_high"))) if told else Interval()
    order = order if told else _estimate(found) if sampled else Interval()
    if not order.known:
        return Interval(), ""
    if told and not found.details["informative"]:
        resolved = _detail(found, "resolved")
        changes = "its errors change sign between levels"
        return Interval(), f"a mean difference is {resolved:.1f} standard errors" if resolved < RESOLVED else changes
    if not (isfinite(order.low) and isfinite(order.high)):
        return Interval(), "its interval is not finite"
    return order, ""


def _local_order(found: Finding, kind: str) -> float:
    known = _detail(found, "local_order")
    alone = isnan(known) and kind == ORDER and found.method and found.tier == ONE_STEP
    return found.estimate if alone else known


def _value(found: Finding, kind: str, path: Interval) -> tuple[Interval, str]:
    if kind != ORDER:
        return (value, kind) if (value := _estimate(found)).known else (Interval(), "")
    if not isnan(moments := _detail(found, "moment_order")):
        return Interval(moments), AT_END
    at_once = found.method and found.tier == AT_ONCE
    value = _estimate(found) if at_once and isnan(_detail(found, "local_order")) and not path.known else Interval()
    # All that is known may be that an order is at least so high.
    told = value if isfinite(value.low) or value.value == inf else Interval()
    return (told, ORDER) if told.known else (Interval(), "")
