"""Names of forms with their indefinite article."""

# Letters whose names begin with a vowel sound, as in "an SDE".
SPOKEN_WITH_VOWEL = frozenset("AEFHILMNORSX")


def article(name: str) -> str:
    """Return a name with its article: an SDE, a HolonomicSDAE, an IndexOneSDAE.

    Parameters
    ----------
    name : str
        Name of a class; leading capitals are pronounced one by one.
    """
    spelled = len(name) > 1 and name[:2].isupper()
    vowel = name[:1] in SPOKEN_WITH_VOWEL if spelled else name[:1].lower() in "aeio"
    return f"{'an' if vowel else 'a'} {name}"
