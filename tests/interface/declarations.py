"""Reads the public functions out of the headers: a list of (header, return type, name, [(type, name)])."""
import re
from pathlib import Path


def parameter(text):
    text = " ".join(text.split())
    if text == "...":
        return ("...", "")
    array = re.sub(r"\[[^\]]*\]", "", text)
    match = re.fullmatch(r"(.*?)(\w+)", array.strip())
    kind = match.group(1).replace(" *", "*").replace("* ", "*").strip()
    return (kind + ("*" if array != text else ""), match.group(2))


def functions(folder):
    found = []
    for header in sorted(Path(folder).glob("*.h*")):
        text = re.sub(r"/\*.*?\*/", "", header.read_text(), flags=re.S)
        text = re.sub(r"^\s*#.*(\\\n.*)*$", "", text, flags=re.M)
        for match in re.finditer(r"\bKM_API\s+([^;]*?)\b(km_\w+)\(([^;]*?)\)\s*(?:__attribute__[^;]*)?;", text):
            listed = re.sub(r"\w[\w ]*\(\*(\w+)\)\([^)]*\)", r"callback \1", match.group(3))  # a function that is called back
            parameters = [] if listed.strip() == "void" else listed.split(",")
            found.append((header.name, match.group(1).replace(" *", "*").strip(), match.group(2),
                          [parameter(p) for p in parameters]))
    return found
