"""The cut of the code, read from its source: layers, who may import whom, sizes of files and functions."""

import ast
import re
from collections import Counter, defaultdict
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import sdaeverify
import sdaeverify.commands
import sdaeverify.errors
import sdaeverify.measuring
import sdaeverify.numerics
import sdaeverify.probing
import sdaeverify.studying
import sdaeverify.trees
from sdaeverify.report.tables.columns import FILES
from source_trees import ROOT, nodes, parsed, sources, text_of

FRAMEWORK = ROOT / "sdaeverify"
CONTRIBUTED = (ROOT / "plugins", ROOT / "problems")

# The layer of every top-level module or package of the framework: it imports its own layer and lower ones.
LAYERS = {
    "errors": 0,
    "arrays": 0,
    "noise": 1,
    "numerics": 1,
    "forms": 2,
    "contracts": 2,
    "simulate": 3,
    "conformance": 3,
    "probe": 3,
    "verdicts": 4,  # what measures and studies share: the way of a claim to its verdict
    "measures": 4,
    "measuring": 5,
    "probing": 5,
    "store": 4,
    "workers": 5,
    "trees": 5,
    "study": 5,
    "report": 6,
    "gate": 6,
    "testing": 7,
    "api": 7,
    "cli": 8,
    "commands": 8,
    "studying": 7,
    "pytest_plugin": 8,
    "__main__": 8,
    "__init__": 8,
}
# Beside the layers: the registry and what it is made of. It knows forms and schemes, and is known from the study on.
SIDE = {"registry"}
HIGHEST_KNOWN, LOWEST_USER = 2, 5
PLUGGY = {"registry"}
# What a plugin may import: the public names of the package and of its public rooms.
ROOMS = (
    sdaeverify,
    sdaeverify.commands,
    sdaeverify.errors,
    sdaeverify.measuring,
    sdaeverify.numerics,
    sdaeverify.probing,
    sdaeverify.studying,
    sdaeverify.trees,
)
PUBLIC = {f"{module.__name__}.{public}" for module in ROOMS for public in module.__all__}
SHIPPED = {
    f"sdaeverify_{kind}"
    for kind in (
        "adaptive",
        "hunt",
        "runs",
        "schemes",
        "problems",
        "measures",
        "orders",
        "bridges",
        "lab",
        "sealed",
        "solvers",
        "wire",
    )
}

STRING_METHODS = set(dir(str)) - set(dir(object)) | {"__contains__"}
JUDGING = {"Claim", "Verdict", "Opinion", "Finding", "Kind", "promises", "claims"}

FRAMEWORK_LINES, CONTRIBUTED_LINES = 500, 500
LONGEST, LONG, SHORT_SHARE = 50, 25, 0.9
MOST_ROOMS, FILES_OF_A_ROOM, SOLE_IMPORTERS = 28, 16, 58
PARAMETERS, COEFFICIENTS = 6, 8


def name(path):
    """Return a path below the root, for messages and test ids."""
    return path.relative_to(ROOT).as_posix()


def top(path):
    """Return the top-level module or package of the framework a file belongs to."""
    return path.relative_to(FRAMEWORK).with_suffix("").parts[0]


def is_for_typing(node):
    """Tell whether a node is a block under ``if TYPE_CHECKING``."""
    return ast.unparse(node.test) == "TYPE_CHECKING"


@cache
def imported_names(path, with_typing=True):
    """Return the absolute dotted names a file imports; ``from a import b`` gives a.b, whatever b is."""
    found, tree = set(), parsed(path)
    blocks = () if with_typing else filter(is_for_typing, nodes(tree, ast.If))
    hidden = {below for block in blocks for below in nodes(block)}
    for node in (each for each in nodes(tree, ast.Import, ast.ImportFrom) if each not in hidden):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        else:
            package = path.parent.relative_to(ROOT).parts
            start = package[: len(package) - node.level + 1] if node.level else ()
            stem = [*start, *([node.module] if node.module else [])]
            found |= {".".join([*stem, alias.name]) for alias in node.names}
    return found


@cache
def module_file(dotted):
    """Return the file of the longest part of a dotted name that is a module of the framework, or None."""
    parts = dotted.split(".")
    for length in range(len(parts), 0, -1):
        stem = ROOT.joinpath(*parts[:length])
        for candidate in (stem.with_suffix(".py"), stem / "__init__.py"):
            if parts[0] == FRAMEWORK.name and candidate.is_file():
                return candidate
    return None


def guilty(found, *folders):
    """Return what a function of a file finds, by file, where it finds anything in the files below some folders."""
    return {name(path): sorted(each) for path in sources(*folders) if (each := found(path))}


def imported_files(path, with_typing=True):
    """Return the files of the framework that a file imports."""
    return {file for file in map(module_file, imported_names(path, with_typing)) if file is not None}


def allowed(importer, imported):
    """Tell whether one top-level module may import another."""
    if importer in SIDE:
        return imported in SIDE or LAYERS[imported] <= HIGHEST_KNOWN
    if imported in SIDE:
        return importer == "measures" or LAYERS[importer] >= LOWEST_USER
    return LAYERS[imported] <= LAYERS[importer]


def functions(*folders):
    """Yield (where, function) for every function and method."""
    for path in sources(*folders):
        for node in nodes(parsed(path), ast.FunctionDef):
            yield f"{name(path)}:{node.lineno} {node.name}", node


def length(function):
    """Return the lines of a function without its docstring."""
    docstring = function.body[0] if ast.get_docstring(function) is not None else None
    lines = function.end_lineno - function.lineno + 1
    return lines - (docstring.end_lineno - docstring.lineno + 1 if docstring else 0)


def parameters(function):
    """Return the names of a function's parameters besides self and cls."""
    given = function.args
    names = [argument.arg for argument in (*given.posonlyargs, *given.args, *given.kwonlyargs)]
    return [argument for argument in names if argument not in {"self", "cls"}]


def is_problem(where):
    """Tell whether a function is the problem that its file is named after."""
    file, function = where.split(" ")
    return file.startswith("problems/") and file.split("/")[-1].startswith(f"{function}.py:")


def test_every_module_has_its_place():
    """A new top-level module is put into the table of layers on purpose, not by accident."""
    unknown = {top(path) for path in sources(FRAMEWORK)} - set(LAYERS) - SIDE
    assert not unknown, f"put {sorted(unknown)} into LAYERS or SIDE of {name(Path(__file__))}"


def test_rooms_can_be_overlooked():
    """Neither the top of the package nor any of its folders holds more files than a newcomer can survey."""
    assert len({top(path) for path in sources(FRAMEWORK)} - {"__init__"}) <= MOST_ROOMS
    files = Counter(path.parent for path in sources(FRAMEWORK))
    assert not {name(folder): count for folder, count in files.items() if count > FILES_OF_A_ROOM}


def upwards(path):
    """Return the files of higher layers that a file imports."""
    return {name(file) for file in imported_files(path) if not allowed(top(path), top(file))}


def test_lower_layers_never_import_higher_ones():
    """Imports point downwards, also those for type checkers only."""
    assert guilty(upwards, FRAMEWORK) == {}


def classes():
    """Return where each class name of the framework is defined."""
    found = defaultdict(list)
    for path in sources(FRAMEWORK):
        for node in nodes(parsed(path), ast.ClassDef):
            found[node.name].append(f"{name(path)}:{node.lineno}")
    return found


def test_a_class_name_means_one_thing():
    """No two classes of the framework share a name."""
    assert not {shared: where for shared, where in classes().items() if len(where) > 1}


TOLD = {"reason", "remark", "remarks", "claim", "method"}
PATTERNS = {"match", "fullmatch", "search", "split", "findall", "sub"}


def is_told(node):
    """Tell whether an expression is what is told of a verdict, or its text: a reason, a remark, a claim, a method."""
    if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "str" and node.args:
        return is_told(node.args[0])
    if isinstance(node, ast.Attribute) and node.attr in {"value", "text"}:
        return is_told(node.value)
    return getattr(node, "attr", None) in TOLD or getattr(node, "id", None) in {"reason", "remark"}


def reads_text(node):
    """Tell whether a node of a tree takes a decision by the text of what is told."""
    if isinstance(node, ast.Attribute):
        return is_told(node.value) and node.attr in STRING_METHODS
    if isinstance(node, ast.Compare):
        sides = [node.left, *node.comparators]
        values = any(isinstance(each, ast.Attribute) and each.attr == "value" for each in sides)
        # Two texts may be compared, so that the same is not told twice.
        compared = any(map(is_told, sides)) and not all(map(is_told, sides))
        return compared and not (values or isinstance(node.ops[0], ast.Is | ast.IsNot))
    if isinstance(node, ast.Call):
        matched = isinstance(node.func, ast.Attribute) and node.func.attr in PATTERNS
        return matched and any(map(is_told, node.args))
    return isinstance(node, ast.Subscript) and is_told(node.value)


def readings(tree):
    """Yield the lines of a tree that take a decision by the text of what is told of a verdict."""
    asked = nodes(tree, ast.Attribute, ast.Compare, ast.Call, ast.Subscript)
    return [f"{node.lineno}: {ast.unparse(node)}" for node in asked if reads_text(node)]


def test_the_text_of_what_is_told_is_never_parsed():
    """Whoever decides by a reason, a claim or a method asks the record: no method of strings, no part of its text."""
    assert guilty(lambda path: readings(parsed(path)), FRAMEWORK) == {}


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("finding.reason.startswith('wrong limit')", True),
        ("reason.partition('; about ')[0]", True),
        ("'MemoryError' in lane.reason", True),
        ("finding.reason == 'not probed'", True),
        ("finding.reason[:5]", True),
        ("sampled.remark == TOO_FEW", True),
        ("str(found.claim).startswith('unbiased')", True),
        ("re.fullmatch('at most (.*)', str(found.claim.value))", True),
        ("found.method.partition('guarded by ')", True),
        ("'guarded by' in found.method", True),
        ("found.claim is None", False),
        ("old.remark == new.remark", False),
        ("found.claim.value == Word('bounded')", False),
        ("finding.reason.has(Kind.WRONG_LIMIT)", False),
        ("f'{finding.reason}; and so on'", False),
        ("found = Finding(reason=reason.then('more paths'))", False),
    ],
)
def test_readings_of_texts_are_seen(line, found):
    """What is forbidden would be noticed, what is allowed would not."""
    assert bool(readings(ast.parse(line))) is found


def judging(path):
    """Return the words of judging that a file uses or imports."""
    found = nodes(parsed(path), ast.Name, ast.Attribute)
    used = {getattr(node, "id", None) or getattr(node, "attr", None) for node in found}
    imported = {dotted.rpartition(".")[2] for dotted in imported_names(path)}
    return (used | imported) & JUDGING


def test_probes_know_numbers_and_no_verdicts():
    """What is said of a claim stands in the measures: probes name neither claims nor verdicts."""
    assert guilty(judging, FRAMEWORK / "probe") == {}
    assert judging(FRAMEWORK / "contracts" / "finding.py")


FATE = {"verdict", "excluded", "settled", "p_verified", "p_refuted"}


def changed_fates(path):
    """Return the lines of a file that change what became of a finding: by `replace` with such a field.

    The verdict on a cell of a plan that cannot be run is none on a claim.
    """
    calls = nodes(parsed(path), ast.Call)
    calls = (node for node in calls if not (node.args and ast.unparse(node.args[0]) == "cell"))
    return {
        f"{node.lineno}: {ast.unparse(node)}"
        for node in calls
        if ast.unparse(node.func).endswith("replace") and FATE & {keyword.arg for keyword in node.keywords}
    }


def test_a_finding_is_changed_by_the_rules_of_its_way_alone():
    """Whoever knows more of a finding than its measure says so in a case; no study, gate or report decides."""
    users = [FRAMEWORK / room for room in ("study", "gate", "report", "cli", "testing", "simulate")]
    assert guilty(changed_fates, *users) == {}
    assert changed_fates(FRAMEWORK / "verdicts" / "rules.py")


def given_values(node):
    """Return what a call, an assignment or a return hands on."""
    if isinstance(node, ast.Call):
        return [*node.args, *(keyword.value for keyword in node.keywords)]
    return [node.value] if node.value else []


def saying_diverged(path):
    """Return the lines of a file that give the verdict *diverged*, and do not merely ask for it."""
    giving = nodes(parsed(path), ast.Call, ast.Assign, ast.Return)
    given = ((node, each) for node in giving for each in given_values(node) if isinstance(each, ast.Attribute))
    return {node.lineno for node, each in given if (ast.unparse(each.value), each.attr) == ("Verdict", "DIVERGED")}


def test_one_function_says_that_paths_diverge():
    """Measures give the number of lost paths, and one function of opinions turns it into a verdict."""
    assert [*guilty(saying_diverged, FRAMEWORK)] == ["sdaeverify/verdicts/opinions.py"]
    assert len(saying_diverged(FRAMEWORK / "verdicts" / "opinions.py")) == 1
    assert saying_diverged(ROOT / "plugins" / "sdaeverify_sealed" / "run.py")


def test_modules_import_each_other_in_no_circle():
    """There is an order in which the modules can be read, with what is imported for type checkers only."""
    graph = {name(path): {*map(name, imported_files(path) - {path})} for path in sources(FRAMEWORK)}
    TopologicalSorter(graph).prepare()


def only_importers():
    """Return the modules that exactly one other module imports, each with that one; packages aside."""
    importers = defaultdict(set)
    for path in (*sources(FRAMEWORK), FRAMEWORK / "__init__.pyi"):
        for file in imported_files(path) - {path}:
            importers[file].add(name(path))
    modules = {file: by for file, by in importers.items() if file.name != "__init__.py" and len(by) == 1}
    return {name(file): by for file, by in modules.items()}


def test_few_modules_serve_one_other_alone():
    """What only one module imports is a part of it, unless it is a concept of its own: few are."""
    assert len(only_importers()) <= SOLE_IMPORTERS, only_importers()


def test_only_the_registry_imports_pluggy():
    """The plugin manager is hidden behind the registry."""
    using = {top(path) for path in sources(FRAMEWORK) if "pluggy" in str(imported_names(path))}
    assert using <= PLUGGY


def shipped(path):
    """Return the shipped packages that a file imports."""
    return {dotted.split(".")[0] for dotted in imported_names(path)} & SHIPPED


def test_the_framework_knows_no_scheme_and_no_problem():
    """The shipped packages enter through entry points, never through an import."""
    assert guilty(shipped, FRAMEWORK) == {}
    assert guilty(shipped, *CONTRIBUTED)


def deep(path):
    """Return the names of the framework that a file imports though they are not public."""
    return {dotted for dotted in imported_names(path) if dotted.split(".")[0] == FRAMEWORK.name} - PUBLIC


def test_shipped_plugins_use_the_public_names_only():
    """They import from the public rooms alone, as anybody else's would: measures, commands and experiments, too."""
    assert guilty(deep, *CONTRIBUTED) == {}, "what they need should be public in one of the rooms"
    assert guilty(deep, FRAMEWORK)


@cache
def words_of_users():
    """Return the words of plugins, of packages of others and of the site."""
    folders = (*CONTRIBUTED, ROOT / "tests" / "thirdparty", ROOT / "docs")
    files = [path for folder in folders for path in folder.rglob("*") if path.suffix in {".py", ".md"}]
    texts = (path.read_text(encoding="utf-8") for path in files if "_site" not in path.parts)
    return {word for text in texts for word in re.findall(r"\w+", text)}


def test_a_name_for_authors_has_a_user():
    """What no plugin, no package of others and no page uses is private; users may catch each error by its name."""
    rooms = [room for room in ROOMS if room not in {sdaeverify, sdaeverify.trees}]
    unused = {f"{room.__name__}.{each}" for room in rooms for each in set(room.__all__) - words_of_users()}
    assert unused <= {"sdaeverify.errors.PluginError"}


@pytest.mark.parametrize(
    ("room", "most"),
    [(sdaeverify.measuring, 39), (sdaeverify.probing, 21)],
    ids=["measuring", "probing"],
)
def test_a_public_room_is_narrow_and_explains_itself(room, most):
    """An author of measures meets few names, and each class and function of them in its own words."""
    things = {each: getattr(room, each) for each in room.__all__}
    assert len(things) <= most
    assert not [each for each, thing in things.items() if callable(thing) and not getattr(thing, "__doc__", "")]


def test_files_are_short():
    """A file holds one concept: seldom over 500 lines."""
    limits = [(FRAMEWORK, FRAMEWORK_LINES), *((folder, CONTRIBUTED_LINES) for folder in CONTRIBUTED)]
    lines = {
        name(path): (len(text_of(path).splitlines()), limit) for folder, limit in limits for path in sources(folder)
    }
    assert not {path: counted for path, (counted, limit) in lines.items() if counted >= limit}


def test_functions_are_short():
    """No function has more than 50 lines, and nine of ten have fewer than 25."""
    lengths = {where: length(function) for where, function in functions(FRAMEWORK, *CONTRIBUTED)}
    assert not {where: counted for where, counted in lengths.items() if counted > LONGEST}
    assert sum(counted < LONG for counted in lengths.values()) >= SHORT_SHARE * len(lengths)


def test_functions_have_few_parameters():
    """More than a handful of parameters want to be one record; a problem has those of its equation."""
    counts = {where: len(parameters(function)) for where, function in functions(FRAMEWORK, *CONTRIBUTED)}
    most = {where: COEFFICIENTS if is_problem(where) else PARAMETERS for where in counts}
    assert not {where: count for where, count in counts.items() if count > most[where]}


@pytest.mark.parametrize(
    ("importer", "imported", "verdict"),
    [
        ("noise", "arrays", True),
        ("noise", "numerics", True),
        ("noise", "forms", False),
        ("errors", "noise", False),
        ("measures", "registry", True),
        ("study", "registry", True),
        ("registry", "contracts", True),
        ("registry", "study", False),
        ("study", "__init__", False),
    ],
)
def test_the_rule_of_imports_is_the_drawn_one(importer, imported, verdict):
    """The table is read in the right direction, so that a wrong import would be noticed."""
    assert allowed(importer, imported) is verdict


def test_imports_are_read_from_the_source():
    """Relative, absolute and type-checking imports all count; those for type checkers can be left out."""
    path = FRAMEWORK / "report" / "tables" / "columns.py"
    everything = {name(file) for file in imported_files(path)}
    at_run_time = {name(file) for file in imported_files(path, with_typing=False)}
    assert everything - at_run_time == {"sdaeverify/contracts/measure.py"}
    assert {"sdaeverify/report/cells.py", "sdaeverify/report/verdict_row.py"} <= at_run_time


def asking_for_subclasses(path):
    """Return the lines of a file that ask which subclasses this process happens to have loaded."""
    return {node.lineno for node in nodes(parsed(path), ast.Attribute) if node.attr == "__subclasses__"}


def test_nothing_depends_on_what_a_process_has_loaded():
    """Nobody asks for the subclasses of a class."""
    assert not guilty(asking_for_subclasses, FRAMEWORK)


def subclasses(of):
    """Return the names of all classes below a class."""
    return {kind.__name__ for kind in of.__subclasses__()} | {
        each for kind in of.__subclasses__() for each in subclasses(kind)
    }


FORMS = {each for each in sdaeverify.__all__ if each in subclasses(sdaeverify.Problem)}


def named_forms(path):
    """Return the forms that a file names or imports."""
    named = {node.id for node in nodes(parsed(path), ast.Name)}
    return (named | {dotted.split(".")[-1] for dotted in imported_names(path)}) & FORMS


def test_forms_are_known_by_what_they_offer():
    """No form is named outside its room and the public names: what one can do is asked of it, by kind."""
    naming = {top(ROOT / file) for file in guilty(named_forms, FRAMEWORK)}
    assert naming == {"forms"}, "ask capability(kind) of the problem"


@cache
def shipped_names():
    """Return the names of shipped schemes and problems of more than one word: no word of a text by chance."""
    schemes = {
        node.value.value
        for path in sources(*CONTRIBUTED)
        for node in nodes(parsed(path), ast.AnnAssign)
        if ast.unparse(node.target) == "name" and node.value is not None
    }
    problems = {path.stem.replace("_", "-") for path in sources(CONTRIBUTED[1]) if not path.stem.startswith("_")}
    return {each for each in schemes | problems if "-" in str(each)}


def named_plugins(path):
    """Return the shipped schemes and problems whose name is a text of a file."""
    texts = {node.value for node in nodes(parsed(path), ast.Constant)}
    return texts & shipped_names()


def test_the_framework_names_no_scheme_and_no_problem():
    """What is shipped is known by what it declares, not by its name; texts of help and templates may show one."""
    assert guilty(named_plugins, FRAMEWORK) == {}
    assert guilty(named_plugins, *CONTRIBUTED)


MEASURES = {
    node.value.value
    for path in sources(FRAMEWORK / "measures", ROOT / "plugins" / "sdaeverify_measures")
    for node in nodes(parsed(path), ast.AnnAssign)
    if ast.unparse(node.target) == "name" and node.value is not None
}


def measures_listed(path):
    """Return the measures whose names stand side by side in a set, tuple or list of texts of a file."""
    groups = [node.elts for node in nodes(parsed(path), ast.Set, ast.Tuple, ast.List)]
    texts = [{each.value for each in group if isinstance(each, ast.Constant)} & MEASURES for group in groups]
    return {listed for found in texts if len(found) > 1 for listed in found}


def test_measures_declare_what_is_asked_of_them():
    """No list of measures stands outside their room: what one is like is declared by its class."""
    elsewhere = {file for file in guilty(measures_listed, FRAMEWORK) if "/measures/" not in file}
    assert elsewhere == set()
    assert {"strong", "weak", "drift", "limits", "intervals", "uniformity"} <= MEASURES


def test_a_cell_keeps_its_match():
    """A problem is offered to a scheme where a cell is planned and where a worker begins, nowhere in between."""
    callers = {
        name(path)
        for path in sources(FRAMEWORK)
        for node in nodes(parsed(path), ast.Call)
        if isinstance(node.func, ast.Name) and node.func.id == "match"
    }
    # The rest plans cells of its own: the lab, the kit, and the search for a problem that is run on request.
    rooms = {"sdaeverify/report", "sdaeverify/testing"}
    own = {caller for caller in callers if "/".join(caller.split("/")[:2]) in rooms}
    assert callers - own == {
        f"sdaeverify/{file}.py"
        for file in ("gate/untested", "simulate/ensemble", "store/behaviour", "study/look_judgement", "study/plan")
    }


def test_parts_of_scipy_are_loaded_when_they_are_used():
    """Nobody imports a part of scipy by name: as an attribute it is loaded on first use, and a list needs none."""
    named = {
        name(path)
        for path in sources(FRAMEWORK, ROOT / "plugins", ROOT / "problems")
        for node in nodes(parsed(path), ast.Import, ast.ImportFrom)
        if (isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "scipy")
        or (isinstance(node, ast.Import) and any(alias.name.startswith("scipy.") for alias in node.names))
    }
    assert named == set()


@cache
def enumerations(*folders):
    """Return by name the texts of each enumeration below some folders."""
    found = {}
    for path in sources(*folders):
        for node in nodes(parsed(path), ast.ClassDef):
            if any(ast.unparse(base).endswith("Enum") for base in node.bases):
                values = (each.value for each in node.body if isinstance(each, ast.Assign))
                found[node.name] = {value.value for value in values if isinstance(value, ast.Constant)}
    return found


def test_there_is_one_enumeration_of_verdicts():
    """Cells, classes of equations, solvers and hunts have the same verdicts: whoever reads one family reads all."""
    verdicts = {
        name for name, texts in enumerations(FRAMEWORK, *CONTRIBUTED).items() if texts & {"verified", "refuted"}
    }
    assert verdicts == {"Verdict"}


def test_there_is_one_enumeration_of_what_was_expected():
    """Gates and checks of the kit pass, fail, and fail as expected in the same words."""
    found = enumerations(FRAMEWORK, *CONTRIBUTED)
    assert {name for name, texts in found.items() if texts & {"passed", "failed", "skipped"}} == {"Status"}


def test_one_table_of_a_run_has_verdicts():
    """A row of verdicts.csv is the only place where the folder of a run says what became of a claim."""
    runs = [path.parent for path in (ROOT / "reports").rglob("verdicts.csv")]
    tables = [(run, file) for run in runs for file in (*run.glob("*.csv"), *run.glob("details/*.csv"))]
    heads = {(run, file): file.read_text(encoding="utf-8").partition("\n")[0].split(",") for run, file in tables}
    assert len(runs) > 5
    assert {file.relative_to(run).as_posix() for (run, file), head in heads.items() if "verdict" in head} == {
        "verdicts.csv"
    }
    assert {file for file, known in FILES.items() if "verdict" in {column.name for column in known}} == {
        "verdicts.csv"
    }


def texts_of_codes(tree):
    """Return the lines of a tree that give exit codes words of their own."""
    tables = nodes(tree, ast.Dict)
    pairs = (pair for table in tables for pair in zip(table.keys, table.values, strict=True) if pair[0] is not None)
    own = (code for code, words in pairs if isinstance(words, ast.Constant | ast.JoinedStr))
    return {f"{code.lineno}: {ast.unparse(code)}" for code in own if ast.unparse(code).startswith("ExitCode.")}


def test_there_is_one_table_of_exit_codes():
    """The enumeration says what each code means, for every command: no file has words of its own for one."""
    assert guilty(lambda path: texts_of_codes(parsed(path)), FRAMEWORK, *CONTRIBUTED) == {}
    assert texts_of_codes(ast.parse('WORDS = {ExitCode.OK: "all is well"}'))
    assert [name for name, _ in enumerations(FRAMEWORK, *CONTRIBUTED).items() if "Exit" in name] == ["ExitCode"]
