"""A gate under way: run, judge, compare with the lock file, write and print the reports."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click

from ..api import Result
from ..errors import UsageError
from ..gate.gate_plan import gate_plan, omitted_measures
from ..gate.gated import Gated, limit_lines
from ..gate.lock import Claims, compare, locked_tiers, read_lock, restrict, write_lock
from ..gate.outcomes import Outcome, idle, outcomes, why_not_reached
from ..gate.policy import Policy
from ..gate.untested import Untested, find_untested
from ..gate.writers.record import json_report
from ..gate.writers.text import text_report
from ..registry.load import Registry
from ..report.files import require_writable, write_json
from ..workers.executors import Workers
from ..workers.limits import Limits
from .console import complain, output_to_stderr
from .exit_codes import ExitCode, code_of_gate
from .running import ENDINGS, Run, advance, call_report_hooks, halt_of, workers

MOST_UNTESTED = 20
GATE = "gate.json"


@dataclass(frozen=True)
class Request:
    """What a command line asks for.

    Attributes
    ----------
    policy : Policy
    registry : Registry
    arguments : tuple of str
        Words of the command line.
    folder : Path
        Of the reports.
    jobs : int
        Worker processes at most.
    limits : Limits or None
    progress : str
    write_lock, reuse : bool
    narrowed : bool
        Whether the command line selects schemes, problems or measures: the lock file is not held against the rest.
    partial : bool
        Whether it selects problems or measures: claims need not be tested by these.
    """

    policy: Policy
    registry: Registry
    arguments: tuple[str, ...]
    folder: Path
    jobs: int
    limits: Limits | None
    progress: str
    write_lock: bool
    reuse: bool
    narrowed: bool
    partial: bool


def carry_out_gate(request: Request) -> tuple[Gated | None, ExitCode]:
    """Run a gate, write ``gate.json`` and print the report.

    Parameters
    ----------
    request : Request

    Returns
    -------
    Gated or None
        None if it was not carried to its end.
    ExitCode

    Raises
    ------
    UsageError
        If a name is unknown, the lock file is missing or damaged, or a report cannot be written.
    """
    policy = request.policy
    # What stands in its place and is no lock file must not be overwritten.
    before = read_lock(policy.lock_file) if request.write_lock else locked_tiers(policy)
    require_writable(request.folder)
    _remove_report(request.folder / GATE)
    with workers(request.jobs, request.limits, request.registry) as crew:
        with output_to_stderr():
            plan = gate_plan(request.registry, policy, crew.executor)
        run = Run(plan, policy.settings, request.registry, request.arguments, request.folder, not request.reuse)
        result, code = _run_to_its_end(run, crew, request.progress)
    if result is None:
        return None, code
    run.write_page()
    call_report_hooks(run, result)
    gated = _judge(run, result, request, {} if request.write_lock else before)
    for line in (*text_report(gated), gated.words):
        click.echo(line)
    # Written last: where it is, the gate came to its end.
    write_json(json_report(gated), request.folder / GATE)
    return gated, ExitCode(gated.code)


def _run_to_its_end(run: Run, crew: Workers, kind: str) -> tuple[Result | None, ExitCode]:
    """Return what a run came to; None and why not if it did not come to its end."""
    try:
        return advance(run, crew, kind), ExitCode.OK
    except ENDINGS as error:
        halt = halt_of(error)
        run.stop(halt.why)
        complain("error", f"{halt.why}; {run.so_far}; nothing is gated{halt.advice}")
        return None, halt.code


def _judge(run: Run, result: Result, request: Request, tiers: dict[str, Claims] | None) -> Gated:
    policy = request.policy
    violations, news = tuple[str, ...](), tuple[str, ...]()
    found = tuple(outcomes(result.results, policy))
    if tiers and policy.tier in tiers:
        locked = restrict(tiers[policy.tier], request.registry, policy, narrowed=request.narrowed)
        violations, news = compare(locked, found)
    idle_claims = _find_untested(run, result, request)
    missed = [str(each) for each in idle_claims if not each.chosen]
    code = code_of_gate(found, policy, complete=not (violations or missed))
    return Gated(
        found,
        policy,
        run.settings,
        violations,
        code,
        f"exit code {code.value}: {code.words}",
        request.registry.files,
        frozenset(result.run["unnamed"]),
        (*_warnings(found, request), *limit_lines(missed, MOST_UNTESTED)),
        (
            *news,
            *_notes(found, request, tiers),
            *limit_lines([str(each) for each in idle_claims if each.chosen], MOST_UNTESTED),
            *(_reuse(run) if request.reuse else ()),
        ),
    )


def _warnings(found: tuple[Outcome, ...], request: Request) -> Iterator[str]:
    if not found:
        yield "no claim of the selected schemes is tested by the selected problems and measures"
    # A smaller selection need not reach what is expected to fail.
    whole = not request.narrowed and not request.policy.budget.quick
    for one in idle(found, request.policy):
        if why := why_not_reached(one, request.registry, found) or ("remove it" if whole else ""):
            yield f"no finding matches the expected failure {one} ({one.reason}); {why}"


def _notes(found: tuple[Outcome, ...], request: Request, tiers: dict[str, Claims] | None) -> Iterator[str]:
    file, tier = request.policy.lock_file, request.policy.tier
    if request.write_lock:
        yield from write_lock(request.policy, found)
    elif tiers is None:
        yield f"there is no lock file, so nobody notices a claim that is dropped; gate --write-lock writes {file}"
    elif tier not in tiers:
        yield f"{file} locks nothing for tier {tier}; gate --tier {tier} --write-lock adds it"
    if not (request.policy.schemes or request.policy.distribution):
        yield describe_everything(request.registry)
    if skipped := omitted_measures(request.registry, request.policy):
        yield f"tier {tier} leaves out {', '.join(skipped)}; a larger tier runs them, or a policy that names them"


def describe_everything(registry: Registry) -> str:
    """Return whose claims are gated where neither schemes nor a project are named, and whose are not."""
    left = [name for name, entry in registry.schemes.items() if entry.on_request]
    taken = f"no policy and no project name schemes: the claims of all {len(registry.schemes) - len(left)} are gated"
    return f"{taken}; run on request are {', '.join(left)}" if left else taken


def _find_untested(run: Run, result: Result, request: Request) -> list[Untested]:
    """Return the claims that are not tested; of a part of the problems or measures nothing is known but names."""
    found = find_untested(request.registry, request.policy, run.plan, result.results)
    if request.partial:
        return [each for each in found if each.claim.measure not in request.registry.measures]
    return found


def _reuse(run: Run) -> list[str]:
    store = run.study.store
    return [store.summary()] if store is not None and store.telling else []


def _remove_report(file: Path) -> None:
    """Remove what an earlier gate has left: nobody shall take it for this one's where this one does not end."""
    try:
        file.unlink(missing_ok=True)
    except OSError as error:
        raise UsageError(f"cannot replace {file}: {error.strerror or error}; choose another --out") from error
