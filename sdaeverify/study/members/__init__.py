"""Claims put to random members of a form: equations of a class that are drawn, not chosen."""
