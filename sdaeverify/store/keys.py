"""Everything that determines the evidence of a scheme on a block of paths, by name, so that a change can be told."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict

from ..contracts.measure import Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import SCREENING, Settings
from ..contracts.specs import ProblemSpec
from .code import arithmetic, code_of, framework_code

Ingredients = Mapping[str, str]
# What of the settings says how many paths there are in all and when to stop: a block does not depend on it.
BUDGET = frozenset({"paths", "looks", "confidence", "family"})
# Which levels begin is no part of what they are.
UNKEYED = BUDGET | {"first_levels"}


def asked_for(scheme: Scheme, spec: ProblemSpec, settings: Settings, block: int) -> Ingredients:
    """Return what evidence is about: scheme, problem, block of paths, and the settings that it depends on.

    Parameters
    ----------
    scheme : Scheme
    spec : ProblemSpec
        The problem by name and parameters.
    settings : Settings
    block : int
        Of paths; `SCREENING` for what is found without paths.
    """
    numbers = {name: str(value) for name, value in asdict(settings).items() if name not in UNKEYED}
    drawn = "none"
    if block != SCREENING:
        drawn = f"{settings.sizes[block]} drawn, {settings.paths_of(block)} used"
    names = {"scheme": scheme.label, "problem": spec.label, "index": str(block)}
    return {**names, "paths of the block": drawn, **numbers}


def made_with(scheme: Scheme, spec: ProblemSpec) -> Ingredients | None:
    """Return what evidence is made with: code and versions; None where code without a source takes part."""
    own, other = code_of(type(scheme)), code_of(spec.function)
    if own is None or other is None:
        return None
    libraries = sorted({*arithmetic(), *own.libraries, *other.libraries})
    return {
        "code of the scheme": own.digest,
        "code of the problem": other.digest,
        "version of a library": ", ".join(libraries),
        "framework": framework_code(),
    }


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
