"""Reads the pages of the documentation: their fenced blocks, headings and links. See docs/howto/write_a_page.md."""

import dataclasses
import pathlib
import re
import shlex

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
# Made by scripts/docs when the site is built; links to them are checked there.
GENERATED = {"docs/nodes.md", "docs/tactus.schema.json", "docs/reference/commands.md", "docs/reference/profiles.md"}

FENCE = re.compile(r"^( *)(`{3,})(.*)$")
LINK = re.compile(r"(!?)\[(?:[^\]\\]|\\.)*\]\(([^()\s]+)(?: +\"[^\"]*\")?\)")
SOURCE = re.compile(r"\bsrc=\"([^\"]+)\"")


@dataclasses.dataclass
class Fence:
    page: pathlib.Path
    line: int  # of the opening fence, from 1
    language: str
    options: dict
    text: str

    @property
    def place(self):
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def pages():
    """Every page that a reader can open: the site's, README.md, CHANGELOG.md and the instruments'."""
    found = [path for path in sorted(DOCS.rglob("*.md")) if not path.name.endswith(".in.md")]
    return [ROOT / "README.md", ROOT / "CHANGELOG.md", *found, *sorted(ROOT.glob("instruments/*/README.md"))]


def options_of(info):
    """The words of an info string after the language: flags, and name="value"."""
    language, _, rest = info.strip().partition(" ")
    options = {}
    for word in shlex.split(rest):
        name, _, value = word.partition("=")
        options[name] = value
    return language, options


def fences(page, text=None):
    found, opened, body = [], None, []
    for number, line in enumerate((page.read_text() if text is None else text).split("\n"), 1):
        match = FENCE.match(line)
        if opened is None and match:
            opened = (number, match[1], match[2], match[3])
            body = []
        elif opened is not None and line.strip() == opened[2]:
            language, options = options_of(opened[3])
            found.append(Fence(page, opened[0], language, options, "\n".join(body)))
            opened = None
        elif opened is not None:
            body.append(line.removeprefix(opened[1]))
    return found


def indented_commands(page):
    """(line, command) of code that is indented by four spaces instead of fenced."""
    fence = None
    for number, line in enumerate(page.read_text().split("\n"), 1):
        match = FENCE.match(line)
        if match and (fence is None or line.strip() == fence):
            fence = match[2] if fence is None else None
        elif fence is None and re.match(r"    (?:\$ )?(?:build/\w+/tactus|tactus|scripts/\w+) ", line):
            yield number, re.split(r"\s{3,}", line.strip())[0]


def prose(text):
    """The text with fenced blocks, indented code, code spans and comments blanked; lines keep their numbers."""
    lines, fence = [], None
    for line in text.split("\n"):
        match = FENCE.match(line)
        if fence is None and match:
            fence = match[2]
            lines.append("")
        elif fence is not None:
            if line.strip() == fence:
                fence = None
            lines.append("")
        else:
            lines.append("" if line.startswith("    ") and not re.match(r" +(?:[-*]|\d+\.) ", line) else line)
    blank = lambda match: re.sub(r"[^\n]", " ", match[0])
    text = re.sub(r"<!--.*?-->", blank, "\n".join(lines), flags=re.S)
    return re.sub(r"(?<!`)(`+)(?!`)(?:(?!\n\n).)+?(?<!`)\1(?!`)", blank, text, flags=re.S)


def code_spans(text):
    """Commands in running text: the code spans that begin with `tactus `."""
    kept = re.sub(r"^ *```.*?^ *```$", lambda match: "\n" * match[0].count("\n"), text, flags=re.S | re.M)
    for match in re.finditer(r"(?<!`)`((?:build/\w+/)?tactus [^`]+)`", kept):
        yield kept.count("\n", 0, match.start()) + 1, " ".join(match[1].split())


def links(page, text=None):
    """(line, target) of each link and picture."""
    kept = prose(page.read_text() if text is None else text)
    for pattern, group in ((LINK, 2), (SOURCE, 1)):
        for match in pattern.finditer(kept):
            yield kept.count("\n", 0, match.start()) + 1, match[group]


def slug(heading):
    """The anchor that GitHub and the site give to a heading."""
    heading = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").replace("**", "")
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def anchors(text):
    found, fence = set(), None
    for line in text.split("\n"):
        match = FENCE.match(line)
        if match and (fence is None or line.strip() == fence):
            fence = match[2] if fence is None else None
        heading = re.match(r"#{1,6} (.*)", line)
        if fence is None and heading:
            name, count = slug(heading[1]), 0
            while (name if not count else f"{name}-{count}") in found:
                count += 1
            found.add(name if not count else f"{name}-{count}")
    return found
