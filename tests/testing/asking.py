"""One check of the kit put to one subject."""

from facade import ProblemSubject, SchemeSubject, load_plugins, problem_of, problem_questions, scheme_questions


def of_scheme(scheme, check, problem):
    """Return the answer to a check of a scheme on a problem."""
    questions = scheme_questions(SchemeSubject(scheme, load_plugins()), [problem], None)
    return only(questions, check)


def of_problem(problem, check):
    """Return the answer to a check of a problem function, a recipe or a label."""
    return only(problem_questions(ProblemSubject(problem_of(problem, load_plugins()), load_plugins()), None), check)


def only(questions, check):
    """Return the answer to the one question with this name."""
    (question,) = [question for question in questions if question.check.name == check]
    return question.answer()
