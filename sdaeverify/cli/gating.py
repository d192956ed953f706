"""Execution of a gate: run, judge, compare with the lock file, write and print the reports."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from ..api import Result
from ..errors import FAULTS, SdaeverifyError, UsageError, one_line
from ..gate.against import changes, in_one_line, read_gate
from ..gate.gate_plan import gate_plan, gates_everything, omitted_measures
from ..gate.gated import Gated
from ..gate.hunted import search
from ..gate.lock import Claims, compare, locked_tiers, read_lock, restrict, undecided_claims, write_lock
from ..gate.outcomes import Outcome, idle, outcomes, require_named, why_never
from ..gate.policy import Policy
from ..gate.untested import find_untested
from ..gate.words import json_report, limit_lines, text_report
from ..registry.load import Registry
from ..report.files import require_writable, write_json
from ..report.folders import require_run_folder, run_of
from ..report.saved import GATE
from ..study import Plan
from ..study.class_tests import NO_TESTS
from ..study.examination import Work, begin_all
from ..study.unseen import unseen_features
from ..workers.executors import Workers
from ..workers.limits import Limits
from .codes_of_runs import code_of_gate
from .console import complain, output_to_stderr
from .exit_codes import ExitCode
from .running import ENDINGS, Run, advance, call_report_hooks, halt_of, run_on_workers, workers

MOST_UNTESTED = 20


def is_narrowed(options: Mapping[str, Any]) -> bool:
    """Return whether the command line selects a part, in which case missing locked claims are not reported."""
    return any(options[name] for name in ("schemes", "problems", "measures"))


def carry_out_gate(
    policy: Policy,
    registry: Registry,
    arguments: tuple[str, ...],
    options: Mapping[str, Any],
    held_to: tuple[int, Limits | None],
) -> tuple[Gated | None, ExitCode]:
    """Run a gate, write ``gate.json`` and print the report.

    Parameters
    ----------
    policy : Policy
    registry : Registry
    arguments : tuple of str
        Words of the command line.
    options : mapping
        Options of the command line.
    held_to : tuple of int and Limits
        Largest number of worker processes, and limits of each.

    Returns
    -------
    Gated or None
        None if the gate did not complete.
    ExitCode

    Raises
    ------
    UsageError
        If a name is unknown, the lock file is missing or damaged, or a report cannot be written.
    """
    # Read before the run: a file in its place that is not a lock file must not be overwritten.
    before = read_lock(policy.lock_file) if options["write_lock"] else locked_tiers(policy)
    earlier = None if options["against"] is None else read_gate(options["against"])
    require_run_folder(options["out"])
    if options["write_lock"]:
        # Checked before the run rather than after it.
        require_writable(policy.lock_file.parent, "lock of the policy")
    _remove_report(options["out"] / GATE)
    narrowed = is_narrowed(options)
    beside = [] if narrowed else _begin_examinations(registry, policy)
    with workers(*held_to, registry) as crew:
        plan = _plan(registry, policy, crew, narrowed=narrowed)
        if gates_everything(registry, policy):
            # Reported before the run, because it takes long and may be unintended.
            complain("", describe_everything(registry, policy.file))
        given = policy.settings, registry, arguments, options["out"], not options["reuse"]
        run = Run(plan, *given, orders=policy.asks_classes)
        result, code = _run_to_its_end(run, crew, options["progress"])
    if result is not None and beside:
        result, code = _examine(run, beside, held_to[0], options["progress"])
    if result is None:
        return None, code
    run.write_page()
    call_report_hooks(run, result)
    gated = _judge(run, result, policy, options, {} if options["write_lock"] else before)
    if earlier is not None:
        changed = changes(earlier, gated.outcomes, narrowed=narrowed)
        gated = replace(gated, changes=changed, notes=(*gated.notes, in_one_line(changed, options["against"])))
    for line in (*text_report(gated), gated.words):
        click.echo(line)
    # Written last, so that the file exists only if the gate completed.
    write_json({**json_report(gated), "date": run_of(options["out"])["date"]}, options["out"] / GATE)
    return gated, ExitCode(gated.code)


def _plan(registry: Registry, policy: Policy, crew: Workers, *, narrowed: bool) -> Plan:
    """Return the plan of a gate; errors of an unknown name are prefixed with the policy file."""
    try:
        with output_to_stderr():
            made = gate_plan(registry, policy, crew.executor)
        require_named(registry, policy, made.cells)
        return made
    except UsageError as error:
        if policy.file is None or narrowed:
            raise
        raise UsageError(f"{policy.file}: [tool.sdaeverify]: {error}") from error


def _run_to_its_end(run: Run, crew: Workers, kind: str) -> tuple[Result | None, ExitCode]:
    """Return the result of a run, or None with the exit code if it did not complete."""
    try:
        return advance(run, crew, kind), ExitCode.OK
    except ENDINGS as error:
        halt = halt_of(error)
        run.stop(halt.why)
        complain("error", f"{halt.why}; {run.so_far}; nothing is gated{halt.advice}")
        return None, halt.code


def _begin_examinations(registry: Registry, policy: Policy) -> list[Work]:
    """Return the examinations of plugins; errors of their tables are prefixed with the policy file."""
    try:
        return begin_all(registry, policy.examinations, policy.settings)
    except UsageError as error:
        raise UsageError(f"{policy.file}: [tool.sdaeverify.examinations]: {error}") from error


def _examine(run: Run, beside: list[Work], jobs: int, kind: str) -> tuple[Result | None, ExitCode]:
    """Run the examinations and return the result with them, or None with the exit code."""
    for work in beside:
        try:
            code = run_on_workers(work, jobs, run.registry, kind)
        except (SdaeverifyError, MemoryError):
            raise
        except FAULTS as error:
            complain("error", f"an examination raises {one_line(error)}; nothing is gated")
            return None, ExitCode.NOT_MEASURED
        if code is not ExitCode.OK:
            return None, code
    run.examined = beside
    return run.save(), ExitCode.OK


def _judge(
    run: Run, result: Result, policy: Policy, options: Mapping[str, Any], tiers: dict[str, Claims] | None
) -> Gated:
    registry, narrowed = run.registry, is_narrowed(options)
    violations, news = tuple[str, ...](), tuple[str, ...]()
    found = tuple(outcomes(result.results, policy))
    if tiers and policy.tier in tiers:
        locked_claims = restrict(tiers[policy.tier], registry, policy, narrowed=narrowed)
        violations, news = compare(locked_claims, found, undecided_claims(result.results))
    untested = find_untested(registry, policy, run.plan, result.results)
    if options["problems"] or options["measures"]:
        # For a selection of problems or measures, only the names can be checked.
        untested = [each for each in untested if each.claim.measure not in registry.measures]
    missed, chosen = ([str(each) for each in untested if each.chosen == one] for one in (False, True))
    code = code_of_gate(found, policy, complete=not (violations or missed))
    hunted = search(registry, policy, options["out"])
    if hunted.refuted and code is not ExitCode.NOTHING:
        code = ExitCode.REFUTED
    locked = write_lock(policy, found) if options["write_lock"] else _why_not_locked(policy, tiers)
    store = run.study.store
    reused = [store.summary()] if options["reuse"] and store is not None and store.telling else []
    return Gated(
        found,
        policy,
        run.settings,
        violations,
        hunted.refuted,
        hunted.attacks,
        code,
        f"exit code {code.value}: {code.words}",
        registry.files,
        frozenset(result.run["unnamed"]),
        result.run["examined"],
        (*_warnings(found, policy, registry, narrowed=narrowed), *limit_lines(missed, MOST_UNTESTED)),
        (
            *news,
            *locked,
            *hunted.notes,
            *_left_out(policy, registry),
            *_notes(run, policy),
            *limit_lines(chosen, MOST_UNTESTED),
            *reused,
        ),
    )


def _warnings(found: tuple[Outcome, ...], policy: Policy, registry: Registry, *, narrowed: bool) -> Iterator[str]:
    if not found:
        yield "no claim of the selected schemes is tested by the selected problems and measures"
    # A smaller selection need not contain the expected failures.
    whole = not narrowed and not policy.budget.quick
    for one in idle(found, policy):
        if why := why_never(one, registry, (each.cell for each in found)) or ("remove it" if whole else ""):
            yield f"no finding matches the expected failure {one} ({one.reason}); {why}"


def _why_not_locked(policy: Policy, tiers: dict[str, Claims] | None) -> Iterator[str]:
    file, tier = policy.lock_file, policy.tier
    if tiers is None:
        yield f"without a lock file, a dropped claim goes unnoticed; gate --write-lock writes {file}"
    elif tier not in tiers:
        yield f"{file} has no claims of tier {tier}; gate --tier {tier} --write-lock adds it"


def _left_out(policy: Policy, registry: Registry) -> Iterator[str]:
    if gates_everything(registry, policy):
        yield describe_everything(registry, policy.file)
    if skipped := omitted_measures(registry, policy):
        left = f"tier {policy.tier} leaves out {', '.join(skipped)}"
        yield f"{left}; a larger tier runs them, or a policy that names them"


def describe_everything(registry: Registry, file: Path | None) -> str:
    """Return a sentence on which claims are gated if the policy selects no schemes.

    Parameters
    ----------
    registry : Registry
    file : Path or None
        File of the policy; None if there is none.
    """
    left = [name for name, entry in registry.schemes.items() if entry.on_request]
    names = "no pyproject.toml is here or above" if file is None else f"{file} names no schemes, plugins or project"
    taken = f"{names}: the claims of all {len(registry.schemes) - len(left)} schemes are gated"
    return f"{taken}; run on request are {', '.join(left)}" if left else taken


def _notes(run: Run, policy: Policy) -> Iterator[str]:
    """Yield notes on features that no problem of the gate has, and on omitted tests and examinations."""
    yield from unseen_features(run.plan)
    if policy.asks_classes and not run.study.class_tests:
        yield f"orders: {NO_TESTS}"
    yield from (note for work in run.examined for note in work.notes)
    if policy.examinations and not run.examined:
        yield f"examinations of {', '.join(policy.examinations)} are left out where a part is selected"


def _remove_report(file: Path) -> None:
    """Remove the report of an earlier gate, which must not be mistaken for that of an unfinished one."""
    try:
        file.unlink(missing_ok=True)
    except OSError as error:
        raise UsageError(f"cannot replace {file}: {error.strerror or error}; choose another --out") from error
