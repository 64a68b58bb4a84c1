"""The messages that the library can tell: what its sources hand to the functions that tell errors, warnings and notes."""
import re

TELLING = re.compile(r"\b(km_fail|km_messages_add|km_reader_(?:error|warning|note)|km_robot_(?:error|warn)|km_binder_fault|add_finding|add)\(")


def statement(text, start):
    """From a call's name to its closing bracket; strings may hold brackets."""
    depth, at = 0, start
    for part in re.finditer(r'"(?:\\.|[^"\\])*"|/\*.*?\*/|[()]', text[start:], re.S):
        depth += {"(": 1, ")": -1}.get(part[0], 0)
        if depth == 0 and part[0] == ")":
            at = start + part.end()
            break
    return text[start:at]


def messages(root):
    """(file, first line, last line, the message's words) of every call that tells something of its own: texts that come from
    elsewhere ("%s: %s") are left out."""
    for path in sorted((root / "lib").rglob("*.c")):
        text = path.read_text()
        for found in TELLING.finditer(text):
            if found[1] == "add" and path.name != "check.c" or found.start() == text.rfind("\n", 0, found.start()) + 1:
                continue
            call = statement(text, found.start())
            words = "".join(re.findall(r'"((?:\\.|[^"\\])*)"', re.sub(r"/\*.*?\*/|\bPRI\w+", "", call, flags=re.S)))
            head = text.rfind("\n", 0, found.start()) + 1
            own = re.sub(r"%[-+.*0-9]*z?[a-z]|\\\\.", "", words)
            if not re.search("[a-z]", own) or re.match(r"(static |KM_API )?(void|bool|km_status) ", text[head:]):  # a declaration
                continue
            first = text.count("\n", 0, found.start()) + 1
            yield path.relative_to(root).as_posix(), first, first + call.count("\n"), words


def listed(root):
    """{(file, words): reason} of messages.txt: a line of a file and words, and one of the reason."""
    lines = [line for line in (root / "tests/house/messages.txt").read_text().splitlines() if line and line[0] != "#"]
    return {tuple(line.split(": ", 1)): reason.strip() for line, reason in zip(lines[::2], lines[1::2])}
