"""Unusual schemes that are right, each with a wrong twin."""

from .additive_schemes import CASES as ADDITIVE
from .constrained_schemes import CASES as CONSTRAINED
from .ito_schemes import CASES as ITO
from .langevin_schemes import CASES as LANGEVIN
from .programmed_schemes import CASES as PROGRAMMED
from .stratonovich_schemes import CASES as STRATONOVICH

CASES = (*STRATONOVICH, *ITO, *ADDITIVE, *LANGEVIN, *CONSTRAINED, *PROGRAMMED)
