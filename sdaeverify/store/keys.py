"""Everything that determines the evidence of a scheme on a block of paths, by name, so that a change can be told."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict

from ..measure import Measure
from ..scheme import Scheme
from ..settings import Settings
from ..specs import ProblemSpec
from .sources import framework_source, source_of

Ingredients = Mapping[str, str]
# What of the settings says how many paths there are in all and when to stop: a block does not depend on it.
BUDGET = frozenset({"paths", "looks", "confidence", "family"})


def lane_ingredients(scheme: Scheme, spec: ProblemSpec, settings: Settings, block: int) -> Ingredients | None:
    """Return what determines the paths of a scheme on a block; None where code without a source takes part."""
    sources = {
        "source of the scheme": source_of(type(scheme).__module__),
        "source of the problem": source_of(spec.family.__module__),
    }
    if not all(sources.values()):
        return None
    numbers = {name: str(value) for name, value in asdict(settings).items() if name not in BUDGET}
    drawn = f"{settings.sizes[block]} drawn, {settings.paths_of(block)} used"
    names = {"scheme": scheme.label, "problem": spec.label, "index": str(block)}
    return {**names, "paths of the block": drawn, **numbers, **sources, "framework": framework_source()}


def measure_ingredients(measure: Measure, settings: Settings) -> Ingredients | None:
    """Return what else determines the evidence of a measure; None where its source is unknown."""
    source = source_of(type(measure).__module__)
    if not source:
        return None
    budget = {name: str(getattr(settings, name)) for name in sorted(BUDGET)} if measure.budgeted else {}
    return {"measure": measure.name, f"source of measure {measure.name}": source, **budget}


def key(ingredients: Ingredients) -> str:
    """Return a hash of ingredients."""
    text = json.dumps(ingredients, sort_keys=True)
    return hashlib.blake2b(text.encode(), digest_size=12).hexdigest()


def differences(old: Ingredients, new: Ingredients) -> list[str]:
    """Return the names of the ingredients that differ."""
    return [name for name in new if old.get(name) != new[name]]
