"""The plugin of pytest: ``pytest --sdaeverify`` makes a test of each claimed cell of the policy's schemes.

A last one holds the lock file, if the policy has one, against what the others have run.

Every run of pytest loads this module: what it needs of the rest is imported once it is asked for.
"""

import inspect
from collections.abc import Callable, Generator, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from .gate.lock import Claims as LockedClaims
    from .gate.policy import Policy
    from .registry.load import Registry
    from .study import Cell
    from .testing.claims import ClaimRun

NAME = "sdaeverify"
SESSION = "sdaeverify_session"
LOCK = "lock file"
NOTHING = "no scheme of the policy claims anything on its problems; sdaeverify list shows what is registered"
# What tests are grouped by.
LABELS: tuple[Callable[["Cell"], str], ...] = (lambda cell: cell.spec.label, lambda cell: cell.scheme.label)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup(NAME, "claims of numerical schemes")
    group.addoption(
        "--sdaeverify",
        action="store_true",
        help="Test the claims of registered schemes, as [tool.sdaeverify] in pyproject.toml asks for.",
    )
    group.addoption(
        "--sdaeverify-tier", metavar="TIER", help="Budget: smoke, ci or nightly. [default: that of the policy]"
    )
    group.addoption(
        "--sdaeverify-seed", metavar="N", type=int, help="Seed of all noise. [default: that of the policy]"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Take part in the run if asked to."""
    config.addinivalue_line("markers", f"{NAME}: a claim of a numerical scheme, from --sdaeverify")
    if config.getoption("--sdaeverify"):
        config.pluginmanager.register(Session(config), SESSION)


class Session:
    """What there is to be tested in a run of pytest.

    Parameters
    ----------
    config : pytest.Config
    """

    def __init__(self, config: pytest.Config) -> None:
        self.config = config
        self.run: ClaimRun | None = None
        self.locked: LockedClaims | None = None

    # Before worker processes are started: what is wrong with the policy is said once.
    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionstart(self) -> None:
        """Read the policy and plan the cells.

        Raises
        ------
        pytest.UsageError
            If the policy or its lock file cannot be read, a name is unknown, or a plugin that is asked for cannot
            be used.
        """
        from .errors import SdaeverifyError  # noqa: PLC0415

        try:
            self.run = _plan_run(self.config)
            self.locked = _read_locked_claims(self.run.policy)
        except SdaeverifyError as error:
            raise pytest.UsageError(f"--sdaeverify: {_visible(str(error))}") from error

    def pytest_report_header(self) -> list[str]:
        """Tell what is tested, and which plugins are left out."""
        if self.run is None:
            return []
        from .testing.claims import idle  # noqa: PLC0415

        policy, plan, registry = self.run.policy, self.run.plan, self.run.registry
        where = policy.file or "defaults, as no pyproject.toml is found"
        cells = f"claimed cells: {len(plan.cells)}, problems: {len(plan.problems)}"
        head = f"{NAME}: {cells}, tier {policy.tier}, seed {policy.seed}; policy: {where}"
        broken = [row for row in registry.plugins if row.status == "broken"]
        left_out = (f"plugin {row.name} is broken and left out: {row.reason}" for row in broken)
        unused = idle(plan, policy.expected_failures)
        return [_visible(line) for line in (head, *registry.warnings, *left_out, *unused)]

    @pytest.hookimpl(wrapper=True)
    def pytest_make_collect_report(
        self, collector: pytest.Collector
    ) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
        """Add the claimed cells to what is found in files, and the lock file after them."""
        report = yield
        if self.run is not None and isinstance(collector, pytest.Session):
            report.result.append(Claims.from_parent(collector, name=NAME, nodeid=NAME, run=self.run))
            if self.locked is not None:
                report.result.append(LockItem.of(collector, self.run, self.locked))
        return report

    # Whatever plugins sort tests by, before workers of pytest-xdist tell what they have collected.
    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Note which cells are left to be run, and put the lock file after them."""
        if self.run is not None:
            self.run.wanted = {item.cell for item in session.items if isinstance(item, ClaimItem)}
            session.items.sort(key=lambda item: isinstance(item, LockItem))

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Let no run pass in which there was nothing to be tested."""
        if self._nothing and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.NO_TESTS_COLLECTED

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Say why there was nothing to be tested."""
        if self._nothing:
            terminalreporter.write_line(f"ERROR: --sdaeverify: nothing to test: {NOTHING}", red=True)

    @property
    def _nothing(self) -> bool:
        return self.run is not None and not self.run.plan.cells


class Claims(pytest.Collector):
    """All claimed cells, or those of a problem, or of a scheme on it: part of the name of a test.

    Parameters
    ----------
    run : ClaimRun
    names : tuple of str
        Label of the problem and of the scheme, as far as they are given.
    """

    def __init__(self, *, run: "ClaimRun", names: tuple[str, ...] = (), **of_a_node: Any) -> None:
        super().__init__(**of_a_node)
        self.run, self.names = run, names

    def collect(self) -> Iterator[pytest.Item | pytest.Collector]:
        """Yield the problems, the schemes on a problem, or the cells of a scheme on it."""
        cells, depth = [cell for cell in self.run.plan.cells if self._has(cell)], len(self.names)
        if depth == len(LABELS):
            yield from (ClaimItem.of(self, self.run, cell) for cell in cells)
            return
        for name in dict.fromkeys(LABELS[depth](cell) for cell in cells):
            yield Claims.from_parent(self, name=_visible(name), run=self.run, names=(*self.names, name))

    def _has(self, cell: "Cell") -> bool:
        return all(label(cell) == name for label, name in zip(LABELS, self.names, strict=False))


class _Item(pytest.Item):
    """A test that fails in words."""

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return what is wrong where something that was promised is not there, and the traceback of a defect."""
        if isinstance(excinfo.value, AssertionError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)


class ClaimItem(_Item):
    """The test of a claimed cell.

    Parameters
    ----------
    run : ClaimRun
    cell : Cell
    """

    def __init__(self, *, run: "ClaimRun", cell: "Cell", **of_a_node: Any) -> None:
        super().__init__(**of_a_node)
        self.run, self.cell = run, cell

    @classmethod
    def of(cls, parent: Claims, run: "ClaimRun", cell: "Cell") -> "ClaimItem":
        """Return the test of a cell; workers of pytest-xdist are asked to keep those of a problem together.

        Parameters
        ----------
        parent : Claims
            The problem's collector.
        run : ClaimRun
            What all items share: it computes each cell once.
        cell : Cell
            A scheme on a problem, with a measure.
        """
        item: ClaimItem = cls.from_parent(parent, name=_visible(cell.measure.name), run=run, cell=cell)
        item.add_marker(NAME)
        if parent.config.pluginmanager.hasplugin("xdist"):
            item.add_marker(pytest.mark.xdist_group(f"{NAME} {_visible(cell.spec.label)}"))
        return item

    def runtest(self) -> None:
        """Run the cell, with all others of its problem if it is the first of them."""
        self.run.check(self.cell)

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return where the scheme is written, and what is tested."""
        path, line = _source(type(self.cell.scheme), self.path)
        what = f"{self.cell.measure.name} of {self.cell.scheme.label} on {self.cell.spec.label}"
        return path, line, _visible(what)


class LockItem(_Item):
    """The test of the lock file.

    Parameters
    ----------
    run : ClaimRun
    locked : dict of Key to str
        What is locked for the tier.
    """

    def __init__(self, *, run: "ClaimRun", locked: "LockedClaims", **of_a_node: Any) -> None:
        super().__init__(**of_a_node)
        self.run, self.locked = run, locked

    @classmethod
    def of(cls, session: pytest.Session, run: "ClaimRun", locked: "LockedClaims") -> "LockItem":
        """Return the test of what is locked.

        Parameters
        ----------
        session : pytest.Session
        run : ClaimRun
            What all items share: its outcomes are compared with the lock.
        locked : LockedClaims
            Claims that must be found.
        """
        item: LockItem = cls.from_parent(session, name=LOCK, nodeid=f"{NAME}::{LOCK}", run=run, locked=locked)
        item.add_marker(NAME)
        return item

    def runtest(self) -> None:
        """Hold what is locked against what was run."""
        from .testing.claims import check_lock  # noqa: PLC0415

        workers = getattr(self.config, "workerinput", {}).get("workercount", 1)
        check_lock(self.run, self.locked, workers)

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return where the lock file is."""
        return self.run.policy.lock_file, 0, LOCK


def _plan_run(config: pytest.Config) -> "ClaimRun":
    from .gate.policy import read_policy  # noqa: PLC0415
    from .registry.load import load_registry  # noqa: PLC0415
    from .testing.claims import claim_run  # noqa: PLC0415

    given = {"tier": config.getoption("--sdaeverify-tier"), "seed": config.getoption("--sdaeverify-seed")}
    policy: Policy = replace(
        read_policy(config.rootpath), **{name: value for name, value in given.items() if value is not None}
    )
    registry = load_registry(policy.plugins)
    _require_own(registry, policy.distribution)
    return claim_run(registry, policy)


def _read_locked_claims(policy: "Policy") -> "LockedClaims | None":
    from .gate.lock import locked_tiers  # noqa: PLC0415

    return (locked_tiers(policy) or {}).get(policy.tier)


def _require_own(registry: "Registry", distribution: str) -> None:
    """Check that the plugins of the project under test are not left out."""
    from .errors import PluginError  # noqa: PLC0415
    from .registry.discovery import normalise  # noqa: PLC0415

    for row in registry.plugins:
        own = bool(distribution) and normalise(row.distribution) == normalise(distribution)
        if own and row.status == "broken":
            raise PluginError(f"plugin {row.name} of this project is broken: {row.reason}")


def _source(kind: type, otherwise: Path) -> tuple[Path, int]:
    try:
        return Path(inspect.getsourcefile(kind) or otherwise), inspect.getsourcelines(kind)[1] - 1
    except (OSError, TypeError):
        return otherwise, 0


def _visible(text: str) -> str:
    from .report.plain import visible  # noqa: PLC0415

    return visible(text)
