"""Findings on classes of equations in the folder of a run, for later runs with the same code and behaviour.

Reading executes no code: the file holds texts and numbers.
"""

import hashlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, replace
from functools import cached_property
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any, Protocol

import msgspec

from ..contracts.finding import UNMEASURED, Finding
from ..contracts.scheme import Scheme
from ..errors import UsageError
from ..simulate.ensemble import Entry
from .code import judging_code
from .store import FOLDER, Store

FILE = "classes.msgpack"
FORMAT = 1
# A finding with the name of its measure.
NamedFinding = tuple[str, Finding]
# The fields of a finding except the claim, which is stored as its number among the claims of the scheme.
FIELDS = msgspec.defstruct("FIELDS", [(part.name, part.type) for part in fields(Finding) if part.name != "claim"])


class ClassQuestion(Protocol):
    """Schemes and a class of equations on which findings are wanted; see `ClassTask`."""

    @property
    def tests(self) -> object:
        """The tests of a plugin."""

    @property
    def entries(self) -> tuple[Entry, ...]:
        """The schemes, each with its measures."""

    @property
    def asked(self) -> tuple[str, ...]:
        """What the findings depend on besides entries and code."""


class Record(msgspec.Struct, frozen=True):
    """Findings of a scheme on a class.

    Attributes
    ----------
    made_with : str
        Hash of behaviour and code.
    findings : tuple of (str, int, dict of str to object)
        Name of the measure, number of the claim (0 without one), and the other fields of the finding.
    """

    made_with: str
    findings: tuple[tuple[str, int, dict[str, Any]], ...]


class ClassFindings:
    """Findings on classes of equations in the folder of a store.

    Parameters
    ----------
    store : Store
        Evidence of the run.
    behaviour : mapping of Scheme to str
        Behaviour of the schemes on the problems of the run; findings on other schemes are not stored.
    """

    def __init__(self, store: Store, behaviour: Mapping[Scheme, str]) -> None:
        self.store, self.file, self.behaviour = store, store.folder / FOLDER / FILE, behaviour

    @cached_property
    def records(self) -> dict[str, Record]:
        """Stored findings by scheme and class; none if the file is damaged or of another version."""
        with suppress(OSError, msgspec.MsgspecError):
            written, found = msgspec.msgpack.decode(self.file.read_bytes(), type=tuple[int, dict[str, Record]])
            if written == FORMAT and not self.store.fresh:
                return found
        return {}

    def recall(self, task: ClassQuestion) -> dict[Entry, tuple[NamedFinding, ...]]:
        """Return the stored findings on the entries of a task that were made with the same code and behaviour."""
        found = {}
        for entry in task.entries:
            record = self.records.get(_name(task, entry))
            if record is not None and record.made_with == self._made_with(task, entry):
                with suppress(msgspec.ValidationError, IndexError):
                    known = ((name, _finding(entry.scheme, claim, rest)) for name, claim, rest in record.findings)
                    found[entry] = tuple(known)
        self.store.reused_findings += len(found)
        return found

    def keep(self, task: ClassQuestion, findings: Mapping[Entry, Sequence[NamedFinding]]) -> None:
        """Store findings on entries of a task; errors are not stored, so that the test is made again.

        Raises
        ------
        UsageError
            If the file cannot be written, for example because the disk is full.
        """
        for entry, own in findings.items():
            record = _record(entry, self._made_with(task, entry), own)
            if record is not None:
                self.records[_name(task, entry)] = record
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            with NamedTemporaryFile(dir=self.file.parent, delete=False) as written:
                written.write(msgspec.msgpack.encode((FORMAT, self.records)))
            Path(written.name).replace(self.file)
        except OSError as error:
            raise UsageError(f"cannot write {self.file}: {error.strerror or error}; choose another --out") from error

    def _made_with(self, task: ClassQuestion, entry: Entry) -> str:
        """Return a hash of the behaviour of a scheme and of all code; empty if a part of them is unknown."""
        behaviour = self.behaviour.get(entry.scheme, "")
        code = judging_code(type(entry.scheme), type(task.tests), *map(type, entry.measures)) if behaviour else ""
        return _hash(behaviour, code) if code else ""


def _record(entry: Entry, made_with: str, findings: Sequence[NamedFinding]) -> Record | None:
    """Return the record of findings; None if they are errors, or if a plugin put other objects into them."""
    if not made_with or any(each.verdict in UNMEASURED for _, each in findings):
        return None
    claims = (None, *entry.scheme.promises)
    try:
        plain = [
            (name, claims.index(each.claim), msgspec.to_builtins(replace(each, claim=None)))
            for name, each in findings
        ]
    except (TypeError, ValueError):
        return None
    return Record(made_with, tuple(plain))


def _finding(scheme: Scheme, claim: int, known: Mapping[str, Any]) -> Finding:
    found = msgspec.convert({name: value for name, value in known.items() if name != "claim"}, FIELDS)
    return Finding(claim=(None, *scheme.promises)[claim], **msgspec.structs.asdict(found))


def _name(task: ClassQuestion, entry: Entry) -> str:
    return _hash(entry.scheme.label, *task.asked, *(measure.name for measure in entry.measures))


def _hash(*texts: str) -> str:
    return hashlib.blake2b(repr(texts).encode(errors="surrogatepass"), digest_size=12).hexdigest()
