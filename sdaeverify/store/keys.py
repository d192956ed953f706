"""Everything that determines the evidence of a scheme on a block of paths, by name, so that a change can be told."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import SCREENING, Settings
from ..contracts.specs import ProblemSpec
from .code import Code, arithmetic, code_of, contents, forget, framework_code

Ingredients = Mapping[str, str]
# Of "scheme" and "problem": where the code is, and a hash of the files.
Files = Mapping[str, tuple[tuple[Path, ...], str]]
# Where the code of schemes and problems is.
Sources = tuple[Path, ...]
# What of the settings says how many paths there are in all and when to stop: a block does not depend on it.
BUDGET = frozenset({"paths", "looks", "confidence", "family"})
# Which levels begin is no part of what they are.
UNKEYED = BUDGET | {"guard_levels"}


def lane_ingredients(scheme: Scheme, spec: ProblemSpec, settings: Settings, block: int) -> Ingredients | None:
    """Return what determines the paths of a scheme on a block; None where code without a source takes part.

    Parameters
    ----------
    scheme : Scheme
    spec : ProblemSpec
        The problem by name and parameters.
    settings : Settings
    block : int
        Of paths; `SCREENING` for what is found without paths.
    """
    codes = lane_codes(scheme, spec)
    known = [code for code in codes.values() if code is not None]
    if len(known) < len(codes):
        return None
    digests = {f"code of the {kind}": code.digest for kind, code in zip(codes, known, strict=True)}
    libraries = {"version of a library": ", ".join(sorted({*arithmetic(), *(x for c in known for x in c.libraries)}))}
    numbers = {name: str(value) for name, value in asdict(settings).items() if name not in UNKEYED}
    drawn = "none"
    if block != SCREENING:
        drawn = f"{settings.sizes[block]} drawn, {settings.paths_of(block)} used"
    names = {"scheme": scheme.label, "problem": spec.label, "index": str(block)}
    return {**names, "paths of the block": drawn, **numbers, **digests, **libraries, "framework": framework_code()}


def lane_codes(scheme: Scheme, spec: ProblemSpec) -> dict[str, Code | None]:
    """Return the code of a scheme and of a problem; None where it has no source."""
    return {"scheme": code_of(type(scheme)), "problem": code_of(spec.function)}


def measure_codes(measures: Iterable[Measure]) -> list[Code | None]:
    """Return the code of measures."""
    return [code_of(type(measure)) for measure in measures]


def describe_code(thing: Any) -> str:
    """Return in a word which code a class or function is written in; empty where it has no source."""
    code = code_of(thing)
    return "" if code is None else key({"code": code.digest, "libraries": ", ".join(code.libraries)})


def lane_files(scheme: Scheme, spec: ProblemSpec) -> Files:
    """Return where the code of a scheme and of a problem is, with hashes of the files."""
    codes = lane_codes(scheme, spec).items()
    return {kind: (code.homes, code.saved) for kind, code in codes if code is not None and code.saved}


def describe_changes(given: Files) -> str:
    """Return in words whether another process has read other files than this one; empty if not."""
    changed = [kind for kind, (homes, hashed) in given.items() if contents(homes) != hashed]
    return f"the source of the {' and of the '.join(changed)} was saved" if changed else ""


def read_code(schemes: Iterable[Scheme], specs: Iterable[ProblemSpec], measures: Iterable[Measure]) -> Sources:
    """Read what determines evidence as soon as it is known what is run: files may be saved while that is planned.

    Parameters
    ----------
    schemes : iterable of Scheme
    specs : iterable of ProblemSpec
    measures : iterable of Measure
        Their own code counts, too.

    Returns
    -------
    tuple of Path
        Where the code of schemes and problems is.
    """
    forget()
    framework_code()
    measure_codes(measures)
    things = [*map(type, schemes), *(spec.function for spec in specs)]
    codes = [code for code in map(code_of, things) if code is not None and code.saved]
    return tuple(dict.fromkeys(home for code in codes for home in code.homes))


def read_again(sources: Sources) -> None:
    """Read in another process what `read_code` has read: it is taken for what this process has imported."""
    for home in sources:
        contents((home,))


def measure_ingredients(measure: Measure, settings: Settings) -> Ingredients | None:
    """Return what else determines the evidence of a measure; None where its source is unknown."""
    code = code_of(type(measure))
    if code is None:
        return None
    budget = {name: str(getattr(settings, name)) for name in sorted(BUDGET)} if measure.budgeted else {}
    return {"measure": measure.name, "code": code.digest, "libraries": ", ".join(code.libraries), **budget}


def key(ingredients: Ingredients) -> str:
    """Return a hash of ingredients."""
    text = json.dumps(ingredients, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()


def differences(old: Ingredients, new: Ingredients) -> list[str]:
    """Return the names of the ingredients that differ."""
    return [name for name in new if old.get(name) != new[name]]
