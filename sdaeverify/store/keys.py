"""Everything that determines the evidence of a scheme on a block of paths, by name, so that a change can be told."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict

from ..contracts.measure import NONE_FOLLOW, Followed, Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import SCREENING, Settings
from ..contracts.specs import ProblemSpec
from .code import arithmetic, code_of, framework_code

Ingredients = Mapping[str, str]
# What of the settings says how many paths there are in all and when to stop: a block does not depend on it.
BUDGET = frozenset({"paths", "max_looks", "confidence", "tests_reserved"})
# Which levels begin is no part of what they are.
UNKEYED = BUDGET | {"first_levels"}
MADE_WITH = CODE_OF_SCHEME, CODE_OF_PROBLEM, LIBRARIES, FRAMEWORK = (
    "code of the scheme",
    "code of the problem",
    "version of a library",
    "framework",
)


def lane_ingredients(
    scheme: Scheme, spec: ProblemSpec, settings: Settings, block: int, followed: Followed = NONE_FOLLOW
) -> Ingredients | None:
    """Return what evidence is about and what it is made with; None where code without a source takes part.

    Parameters
    ----------
    scheme : Scheme
    spec : ProblemSpec
        The problem by name and parameters.
    settings : Settings
    block : int
        Of paths; `SCREENING` for what is found without paths.
    followed : Followed
        Names of the measures whose claims say that steps follow the equation: schemes are held to what they claim.
    """
    own, other = code_of(type(scheme)), code_of(spec.function)
    if own is None or other is None:
        return None
    drawn = "none" if block == SCREENING else f"{settings.sizes[block]} drawn, {settings.paths_of(block)} used"
    return {
        "scheme": scheme.label,
        "problem": spec.label,
        "index": str(block),
        "paths of the block": drawn,
        **{f"claims that follow {what}": str(_claimed(scheme, names)) for what, names in followed._asdict().items()},
        **{name: str(value) for name, value in asdict(settings).items() if name not in UNKEYED},
        CODE_OF_SCHEME: own.digest,
        CODE_OF_PROBLEM: other.digest,
        LIBRARIES: ", ".join(sorted({*arithmetic(), *own.libraries, *other.libraries})),
        FRAMEWORK: framework_code(),
    }


def _claimed(scheme: Scheme, measures: frozenset[str]) -> list[str]:
    return sorted({claim.measure for claim in scheme.promises} & measures)


def measure_ingredients(measure: Measure, settings: Settings) -> Ingredients | None:
    """Return what else determines the evidence of a measure; None where its source is unknown."""
    code = code_of(type(measure))
    if code is None:
        return None
    budget = {name: str(getattr(settings, name)) for name in sorted(BUDGET)} if measure.budgeted else {}
    return {"measure": measure.name, "code": code.digest, "libraries": ", ".join(code.libraries), **budget}


def key(ingredients: Ingredients) -> str:
    """Return a hash of what evidence is about: what other code has made of the same is replaced."""
    about = {name: value for name, value in ingredients.items() if name not in MADE_WITH}
    return hashlib.blake2b(json.dumps(about, sort_keys=True).encode(), digest_size=12).hexdigest()
