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
from .sources import code_of, contents, files_of, framework_source, source_of

Ingredients = Mapping[str, str]
# Of "scheme" and "problem": the module, the files that count for it, and a hash of their contents.
Files = Mapping[str, tuple[str, tuple[Path, ...], str]]
# Modules, and the files that count for each.
Sources = tuple[tuple[str, tuple[Path, ...]], ...]
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
    sources = {f"source of the {kind}": source_of(module) for kind, module in _modules(scheme, spec)}
    if not all(sources.values()):
        return None
    loaded = {"code of the scheme": code_of(scheme), "code of the problem": code_of(spec.function)}
    numbers = {name: str(value) for name, value in asdict(settings).items() if name not in UNKEYED}
    drawn = "none"
    if block != SCREENING:
        drawn = f"{settings.sizes[block]} drawn, {settings.paths_of(block)} used"
    names = {"scheme": scheme.label, "problem": spec.label, "index": str(block)}
    return {**names, "paths of the block": drawn, **numbers, **sources, **loaded, "framework": framework_source()}


def thing_source(thing: Any, module: str) -> str:
    """Return a hash of the sources and the loaded code of a scheme or a problem function."""
    return key({"source": source_of(module), "code": code_of(thing)})


def lane_files(scheme: Scheme, spec: ProblemSpec) -> Files:
    """Return the files whose contents are hashed for a scheme and for a problem, and the hashes."""
    found = ((kind, module, files_of(module)) for kind, module in _modules(scheme, spec))
    return {kind: (module, files, contents(module, files)) for kind, module, files in found}


def describe_changes(given: Files) -> str:
    """Return in words whether another process has read other files than this one; empty if not."""
    changed = [kind for kind, (module, files, hashed) in given.items() if contents(module, files) != hashed]
    return f"the source of the {' and of the '.join(changed)} was saved" if changed else ""


def read_sources(schemes: Iterable[Scheme], specs: Iterable[ProblemSpec], measures: Iterable[Measure]) -> Sources:
    """Read what determines evidence as soon as it is known what is run: files may be saved while that is planned.

    Parameters
    ----------
    schemes : iterable of Scheme
    specs : iterable of ProblemSpec
    measures : iterable of Measure
        Their own code counts, too.

    Returns
    -------
    tuple of (str, tuple of Path)
        The modules of schemes and problems with their files.
    """
    for measure in measures:
        source_of(type(measure).__module__)
        code_of(measure)
    things: list[tuple[Any, str]] = [(scheme, type(scheme).__module__) for scheme in schemes]
    things += [(spec.function, spec.function.__module__) for spec in specs]
    for thing, _ in things:
        code_of(thing)
    found = tuple((module, files_of(module)) for module in dict.fromkeys(module for _, module in things))
    read_again(found)
    return found


def read_again(sources: Sources) -> None:
    """Read in another process what `read_sources` has read: it is taken for what this process has imported."""
    for module, files in sources:
        contents(module, files)


def measure_ingredients(measure: Measure, settings: Settings) -> Ingredients | None:
    """Return what else determines the evidence of a measure; None where its source is unknown."""
    source = source_of(type(measure).__module__)
    if not source:
        return None
    budget = {name: str(getattr(settings, name)) for name in sorted(BUDGET)} if measure.budgeted else {}
    known = {f"source of measure {measure.name}": source, f"code of measure {measure.name}": code_of(measure)}
    return {"measure": measure.name, **known, **budget}


def _modules(scheme: Scheme, spec: ProblemSpec) -> tuple[tuple[str, str], ...]:
    return ("scheme", type(scheme).__module__), ("problem", spec.function.__module__)


def key(ingredients: Ingredients) -> str:
    """Return a hash of ingredients."""
    text = json.dumps(ingredients, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()


def differences(old: Ingredients, new: Ingredients) -> list[str]:
    """Return the names of the ingredients that differ."""
    return [name for name in new if old.get(name) != new[name]]
