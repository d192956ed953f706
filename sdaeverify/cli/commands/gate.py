"""``gate``: test the claims of a project and fail if a claim is significantly wrong."""

import os
from contextlib import nullcontext
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click
from msgspec import structs

from ...errors import UsageError
from ...gate.gated import Gated
from ...gate.github import annotations, fence, markdown_report
from ...gate.policy import Policy, read_policy
from ...gate.tiers import TIERS, seed_of
from ...registry.load import Registry
from ...registry.sources import absolute_plugin
from ...workers.limits import read_limits
from ..console import complain
from ..exit_codes import ExitCode, codes_in_words
from ..gating import carry_out_gate, is_narrowed
from ..loading import load_and_warn
from ..options import PLACE, jobs, limits, once, plugins, progress_of_cells, selection

FOLDER = Path("reports", "gate")
# Environment variables of GitHub's runner.
GITHUB, SUMMARY, WORKSPACE = "GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY", "GITHUB_WORKSPACE"
SEEDS = ("fixed", "date")


@click.command(epilog=codes_in_words(), short_help="Test the claims of a project; fail if one is refuted.")
@selection
@plugins
@once("--config", type=PLACE, metavar="FILE", help="File of the policy.  [default: nearest pyproject.toml]")
@once("--tier", metavar="TIER", help=f"Budget: {', '.join(TIERS)}.  [default: that of the policy, ci]")
@once("--alpha", type=float, help="Probability of a false alarm in the run.  [default: that of the policy, 0.01]")
@once("--seed", type=int, help="Seed of all noise.  [default: that of the policy]")
@once("--seed-from", type=click.Choice(SEEDS), help="Use the seed of the policy, or one from today's date (UTC).")
@once("--out", type=PLACE, default=FOLDER, help="Folder of gate.json and of the run.")
@jobs
@progress_of_cells
@once(
    "--against", type=PLACE, metavar="DIR", help="List the claims whose status differs from that in an earlier gate."
)
@click.option("--write-lock", is_flag=True, help="Write the claims of this run into the lock file.")
@limits
@click.option("--reuse/--fresh", help="Reuse evidence in the folder if the code and its results are unchanged.")
@click.pass_context
def gate(context: click.Context, /, **options: Any) -> ExitCode:
    """Test the claims of a project and fail if one is significantly wrong.

    The policy is the table [tool.sdaeverify] of pyproject.toml; options override it. Fails on claims refuted beyond
    their margin, on cells that cannot be measured, on locked claims that are gone, and on verified claims that were
    expected to fail; never because of run times. On GitHub it also annotates the lines of claims and writes a summary
    of the job.
    """
    policy = policy_of(options)
    if options["write_lock"] and is_narrowed(options):
        raise UsageError("--write-lock needs all that the policy selects: leave out -s, -p and -m")
    _require_project(policy)
    on_github = os.environ.get(GITHUB) == "true"
    with fence(click.echo) if on_github else nullcontext():
        gated, code = _run_gate(policy, tuple(context.obj), options)
    if on_github and gated is not None:
        _annotate(gated)
    return code


def _run_gate(policy: Policy, arguments: tuple[str, ...], options: dict[str, Any]) -> tuple[Gated | None, ExitCode]:
    registry = load_and_warn(policy.plugins, lab=bool(policy.examinations))
    if not _own_plugins_work(registry, policy):
        return None, ExitCode.PLUGIN
    held_to = read_limits(
        policy.timeout if options["timeout"] is None else options["timeout"],
        policy.memory or None if options["memory"] is None else options["memory"],
        options["jobs"],
    )
    return carry_out_gate(policy, registry, arguments, options, held_to)


def _require_project(policy: Policy) -> None:
    """Raise if there is no project and no selection, because gating all schemes takes long."""
    if policy.file is None and not (policy.plugins or policy.schemes):
        raise UsageError(
            "no pyproject.toml is here or above, so there is no project to gate; go to its folder, or give --config "
            "FILE, --plugin FILE, or -s '*' for all schemes that are installed"
        )


def policy_of(options: dict[str, Any]) -> Policy:
    """Return the policy of a command line; options override the file.

    Raises
    ------
    UsageError
        If the file or an option is wrong, or two options contradict each other.
    """
    if options["seed"] is not None and options["seed_from"] is not None:
        raise UsageError("contradictory options: --seed and --seed-from; give one of them")
    policy = read_policy(Path.cwd(), options["config"])
    given: dict[str, Any] = {name: options[name] for name in ("tier", "alpha", "seed") if options[name] is not None}
    given |= {name: tuple(options[name]) for name in ("schemes", "problems", "measures") if options[name]}
    if options["seed_from"] == "date":
        given["seed"] = seed_of(datetime.now(UTC).date())
    named = (*policy.plugins, *map(absolute_plugin, options["plugins"]))
    return structs.replace(policy, plugins=tuple(dict.fromkeys(named)), **given)


def _own_plugins_work(registry: Registry, policy: Policy) -> bool:
    """Return whether all plugins of the project load; a broken one would hide its claims."""
    own = [row for row in registry.plugins if policy.distribution and row.distribution == policy.distribution]
    broken = [row for row in own if row.status == "broken"]
    for row in broken:
        complain("error", f"plugin {row.name} of {row.distribution}, which is gated, is broken: {row.reason}")
    return not broken


def _annotate(gated: Gated) -> None:
    for line in annotations(gated, Path(os.environ.get(WORKSPACE) or Path.cwd())):
        click.echo(line)
    if summary := os.environ.get(SUMMARY):
        try:
            with Path(summary).open("a", encoding="utf-8") as file:
                file.write(markdown_report(gated))
        except OSError as error:
            complain("warning", f"cannot write {SUMMARY} {summary}: {error.strerror or error}")
