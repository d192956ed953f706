"""Ingredients of evidence: everything that determines it, by name, so that a message can say which has changed."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict

from ..contracts.measure import ALONG_PATHS, IN_LAW, Measure
from ..contracts.scheme import Scheme
from ..contracts.settings import Settings
from ..contracts.specs import ProblemSpec
from ..contracts.stages import SCREENING
from .code import arithmetic, code_of, framework_code

Ingredients = Mapping[str, str]
# Settings that determine the number of paths and when to stop; the evidence of a block does not depend on them.
BUDGET = frozenset({"paths", "max_looks", "confidence", "tests_reserved"})
# The levels on which paths begin do not affect the evidence on them.
UNKEYED = BUDGET | {"first_levels"}
MADE_WITH = CODE_OF_SCHEME, CODE_OF_PROBLEM, LIBRARIES, FRAMEWORK = (
    "code of the scheme",
    "code of the problem",
    "version of a library",
    "framework",
)


def lane_ingredients(
    scheme: Scheme, spec: ProblemSpec, settings: Settings, block: int, followed: Mapping[str, str] | None = None
) -> Ingredients | None:
    """Return the ingredients of evidence on a lane; None if any of its code has no source.

    Parameters
    ----------
    scheme : Scheme
    spec : ProblemSpec
        The problem by name and parameters.
    settings : Settings
    block : int
        Index of the block of paths; `SCREENING` for evidence without paths.
    followed : mapping of str to str, optional
        `Measure.follows` by name of the measure. The scheme's claims about paths and about their law are ingredients,
        because some checks depend on them.
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
        **{f"claims that follow {what}": _claimed(scheme, followed or {}, what) for what in (ALONG_PATHS, IN_LAW)},
        **{name: str(value) for name, value in asdict(settings).items() if name not in UNKEYED},
        CODE_OF_SCHEME: own.digest,
        CODE_OF_PROBLEM: other.digest,
        LIBRARIES: ", ".join(sorted({*arithmetic(), *own.libraries, *other.libraries})),
        FRAMEWORK: framework_code(),
    }


def _claimed(scheme: Scheme, followed: Mapping[str, str], what: str) -> str:
    return str(sorted({claim.measure for claim in scheme.promises if followed.get(claim.measure) == what}))


def measure_ingredients(measure: Measure, settings: Settings) -> Ingredients | None:
    """Return the further ingredients of a measure's evidence; None if its source is unknown."""
    code = code_of(type(measure))
    if code is None:
        return None
    budget = {name: str(getattr(settings, name)) for name in sorted(BUDGET)} if measure.budgeted else {}
    return {"measure": measure.name, "code": code.digest, "libraries": ", ".join(code.libraries), **budget}


def key(ingredients: Ingredients) -> str:
    """Return a hash of the ingredients except code and versions, so that newer code replaces older evidence."""
    about = {name: value for name, value in ingredients.items() if name not in MADE_WITH}
    return hashlib.blake2b(json.dumps(about, sort_keys=True).encode(), digest_size=12).hexdigest()
