"""Jump-diffusions: a form, its noise, its schemes and its problems; modules without underscore are plugins."""
