"""Claims tested on random members of a form, that is on randomly drawn equations of a class."""
