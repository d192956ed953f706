"""Programs that test the verifier: `selftest` and `calibrate` with their cases; and `new-plugin`.

A plugin registers planted bugs by the hook ``sdaeverify_planted`` and calibration cases by
``sdaeverify_calibration``, each a function without arguments that returns a list of them, marked `hookimpl`, in a
module that an entry point of the group ``sdaeverify.lab`` names.
"""

from .cases import CalibrationCase, Planted

__all__ = ["CalibrationCase", "Planted"]
