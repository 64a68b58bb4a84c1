"""The public headers as cffi reads them, and their comments as docstrings."""
import re
import subprocess


def preprocessed(compiler, includes):
    """What the compiler sees of the headers of kmech, without what they include from elsewhere."""
    command = compiler.split() + ["-E"] + [f"-I{folder}" for folder in includes] + ["-include", "kmech/kmech.h", "-x", "c", "/dev/null"]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    kept, ours = [], False
    for line in text.splitlines():
        marker = re.match(r'# \d+ "(.*)"', line)
        if marker:
            ours = "/kmech/" in marker.group(1)
        elif ours:
            kept.append(line)
    return "\n".join(kept)


def declarations(compiler, includes):
    """Declarations that cffi can parse: no attributes."""
    text = preprocessed(compiler, includes)
    return re.sub(r"__attribute__\s*\(\(.*?\)\)+", "", text, flags=re.S)


def plain(comment):
    lines = [re.sub(r"^\s*\*? ?", "", line) for line in comment.strip().splitlines()]
    return "\n".join(line.rstrip() for line in lines).strip()


def comments(headers):
    """The comment in front of each public function: {name: text}. One comment may stand for several functions."""
    found = {}
    for header in sorted(headers):
        text = header.read_text(encoding="utf-8")
        comment = ""
        for match in re.finditer(r"/\*(.*?)\*/|KM_API[^;]*?\b(km_\w+)\(|\n\n", text, flags=re.S):
            if match.group(1) is not None:
                comment = plain(match.group(1))
            elif match.group(2):
                found[match.group(2)] = comment
            else:
                comment = "" if match.group(0) == "\n\n" else comment
    return found


def module_comments(headers):
    """The comment at the head of each header: {"question": text}."""
    found = {}
    for header in headers:
        match = re.match(r"\s*/\*(.*?)\*/", header.read_text(encoding="utf-8"), flags=re.S)
        if match:
            found[header.stem] = plain(match.group(1))
    return found
