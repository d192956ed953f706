"""Programs about the verifier: self-test, calibration, comparison, experiments of papers, plugin templates."""
