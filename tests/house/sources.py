"""Files and comments of the tree, and baselines: counts of findings that still exist, which may shrink only."""
import os
import re
import sys
from pathlib import Path

SKIPPED = {".git", "build", "node_modules", "__pycache__"}
C_FOLDERS = ("lib", "tools", "tests", "bindings", "examples")
C_ENDINGS = (".c", ".h", ".cc")
# A comment, or text that can hold its marks: a string, a character. Digits come first: C++ separates them by '.
TOKEN = re.compile(
    r"""\b\d[\w.']*|(?P<comment>/\*.*?(?:\*/|\Z)|//(?:\\\n|[^\n])*)|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|[^"'/\d]+|.""",
    re.S)


def files(root, folders=("",), endings=None):
    """Every file below the folders, sorted, as a path relative to root."""
    found = []
    for folder in folders:
        for place, inner, names in os.walk(root / folder):
            inner[:] = [name for name in inner if name not in SKIPPED]
            found += [os.path.relpath(os.path.join(place, name), root).replace(os.sep, "/") for name in names
                      if endings is None or name.endswith(endings)]
    return sorted(found)


def comments(text):
    """(line, text) of every comment of a C text; the text is without the comment's marks and has its line ends. Line comments
    that follow each other are one comment if nothing but blanks lies between them."""
    found, end, last = [], 0, ""
    for token in TOKEN.finditer(text):
        if token["comment"]:
            words = token["comment"]
            kind = words[:2]
            if kind == "//":
                words = re.sub(r"^///?<?", "", words)
            else:
                words = re.sub(r"^/\*[*!]?<?|\*/$", "", words)
                words = re.sub(r"^[ \t]*\*(?!\w)", "", words, flags=re.M)
            between = text[end:token.start()]
            if kind == "//" == last and not between.strip() and between.count("\n") == 1:
                found[-1] = (found[-1][0], found[-1][1] + "\n" + words)
            else:
                found.append((text.count("\n", 0, token.start()) + 1, words))
            end, last = token.end(), kind
    return found


def listed(path):
    """{words: reason} of a white list: a line of words, then an indented line that gives the reason."""
    if not path.exists():
        return {}
    lines = [line for line in path.read_text().splitlines() if line.strip() and line[0] != "#"]
    return {words: reason.strip() for words, reason in zip(lines[::2], lines[1::2])}


def baseline_read(path):
    if not path.exists():
        return {}
    rows = (line.split(" ", 1) for line in path.read_text().splitlines() if line and line[0] != "#")
    return {name: int(count) for count, name in rows}


def baseline_write(path, head, counts):
    path.write_text(head + "".join(f"{counts[name]} {name}\n" for name in sorted(counts) if counts[name]))


def baseline_faults(path, counts):
    """(faults, names with more findings than the baseline)."""
    old, faults, grown = baseline_read(path), [], []
    for name in sorted(set(old) | set(counts)):
        had, has = old.get(name, 0), counts.get(name, 0)
        if has > had:
            grown.append(name)
            faults.append(f"{name}: {has} findings; expected at most {had}")
        elif has < had:
            faults.append(f"{name}: {has} findings, but {path.name} says {had}; --update lowers it")
    return faults, grown


class Lint:
    """A check with a baseline and a white list, tests/house/NAME.baseline and NAME.allowed. findings(root, allowed) gives
    {path: [(line, kind, excerpt)]} and the entries of the white list that nothing needs; self_test() gives an exit status."""

    def __init__(self, name, findings, self_test):
        self.name, self.findings, self.self_test = name, findings, self_test
        self.head = f"# Findings of tests/house/{name} that still exist, per file. --update lowers them; they may not grow.\n"

    def check(self, root, update=False, quiet=False):
        baseline = root / f"tests/house/{self.name}.baseline"
        found, unused = self.findings(root, self.allowed(root))
        counts = {path: len(rows) for path, rows in found.items()}
        if update:
            baseline_write(baseline, self.head, counts)
        faults, grown = baseline_faults(baseline, counts)
        faults += [f"{self.name}.allowed: nothing needs \"{entry}\"" for entry in sorted(unused)]
        if not quiet:
            for path in grown:
                show(path, found[path])
            for fault in faults:
                print(fault)
            print(f"{sum(counts.values())} findings in {len(counts)} files, {len(faults)} faults")
        return 1 if faults else 0

    def main(self):
        root, options = Path(sys.argv[1]), sys.argv[2:]
        if options == ["--self-test"]:
            return self.self_test()
        if options[:1] == ["--list"]:
            found, _ = self.findings(root, self.allowed(root))
            prefix = options[1].rstrip("/")
            rows = {path: found[path] for path in sorted(found) if prefix == "." or path == prefix or path.startswith(prefix + "/")}
            for path, list_of in rows.items():
                show(path, list_of)
            print(f"{sum(map(len, rows.values()))} findings in {len(rows)} files")
            return 0
        return self.check(root, update="--update" in options)

    def allowed(self, root):
        return listed(root / f"tests/house/{self.name}.allowed")


def show(path, rows):
    for line, kind, excerpt in sorted(rows):
        print(f"{path}:{line}: {kind}: {excerpt}")
