"""How large the source is, and how far it is from the house's limits.

python tests/bench/size.py
"""

import ast
import sys
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # started as a script: tests is not an installed package

from tests.bench.tables import print_table

ROOT = Path(__file__).parents[2]

PACKAGES = ("hexcite", "cases", "identification", "planner", "postprocessors")
PROTOCOLS = ("hexcite/cli", "hexcite/reports", "postprocessors/dialects")
"""Commands, pages and readers: each module there is one implementation, named after what it runs, shows or reads."""
PARAMETERS, FIELDS = 7, 14  # at most, of a function outside the command line and of a value


def sizes() -> None:
    """Prints the table."""
    files = [f for p in PACKAGES for f in sorted((ROOT / p).rglob("*.py"))]
    texts = {f: f.read_text(encoding="utf-8") for f in files}
    lengths = {f: len(text.splitlines()) for f, text in texts.items()}
    nodes = [(f, node) for f, text in texts.items() for node in ast.walk(ast.parse(text))]
    classes = [node for _, node in nodes if isinstance(node, ast.ClassDef)]
    own = [f for f in files if f.stem != "__init__" and str(f.parent.relative_to(ROOT)) not in PROTOCOLS]
    stems = Counter(f.stem for f in own)
    names = Counter(node.name for node in classes)
    wide = [
        f"{f.relative_to(ROOT)}:{node.lineno} {node.name}"
        for f, node in nodes
        if isinstance(node, ast.FunctionDef) and "cli" not in f.parts and _parameters(node) > PARAMETERS
    ]
    long = [f"{node.name} ({_fields(node)})" for node in classes if _fields(node) > FIELDS]
    longest = max(lengths, key=lambda f: lengths[f])
    rows = [
        ("lines, blank ones and comments included", f"{sum(lengths.values())}", "30000"),
        ("files", f"{len(files)}", "230"),
        ("classes", f"{len(classes)}", "250"),
        ("90 % of files are at most so long", f"{np.percentile(list(lengths.values()), 90):.0f}", "280"),
        ("longest file", f"{lengths[longest]} ({longest.relative_to(ROOT)})", "420"),
        (
            "file stems that occur more than once outside one protocol",
            f"{sum(n > 1 for n in stems.values())}",
            "0",
        ),
        ("class names that occur more than once", f"{sum(n > 1 for n in names.values())}", "0"),
        (f"functions of more than {PARAMETERS} parameters", f"{len(wide)}", "0"),
        (f"values of more than {FIELDS} fields", f"{len(long)}", "0"),
    ]
    print_table("Size of the source", ("", "is", "at most"), rows)
    twice = (*(s for s, n in stems.items() if n > 1), *(s for s, n in names.items() if n > 1))
    for line in (*wide, *long, *twice):
        print(line)


def _parameters(node: ast.FunctionDef) -> int:
    own = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    return len([a for a in own if a.arg not in ("self", "cls")])


def _fields(node: ast.ClassDef) -> int:
    own = (entry for entry in node.body if isinstance(entry, ast.AnnAssign))
    return sum("ClassVar" not in ast.unparse(entry.annotation) for entry in own)


if __name__ == "__main__":
    sizes()
