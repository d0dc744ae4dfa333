"""Builds the documentation site in build/site: collects its pages in build/site_source, runs mkdocs, checks the result."""

import argparse
import functools
import html.parser
import http.server
import os
import pathlib
import re
import shutil
import subprocess
import sys
import textwrap
import threading
import time
import tomllib
import urllib.parse

import examples
import pages

ROOT, DOCS = pages.ROOT, pages.DOCS
SOURCE, SITE = ROOT / "build/site_source", ROOT / "build/site"
GALLERY = DOCS / "gallery/index.md"


def site_path(file):
    """Where a file of the repository is in the site."""
    name = file.relative_to(ROOT)
    if file.is_relative_to(DOCS):
        return file.relative_to(DOCS)
    if name == pathlib.Path("README.md"):
        return pathlib.Path("index.md")
    if name == pathlib.Path("CHANGELOG.md"):
        return pathlib.Path("changelog.md")
    if name.parts[0] == "instruments" and name.name == "README.md":
        return pathlib.Path("instruments") / f"{name.parts[1]}.md"
    if (file / "README.md").exists() and name.parts[0] == "instruments":
        return pathlib.Path("instruments") / f"{name.parts[1]}.md"
    return pathlib.Path("source") / (name / "index.md" if file.is_dir() else f"{name}.txt")


def wrapped(line, columns=100):
    """A line of a help text, its description wrapped below itself."""
    start = re.match(r"( +\S.*?  +)\S", line) or re.match(r"( +)", line)
    indent = " " * len(start[1]) if start else ""
    return "\n".join(textwrap.wrap(line, columns, subsequent_indent=indent, drop_whitespace=True, replace_whitespace=False)) if len(line) > columns else line


class Source:
    """build/site_source."""

    def __init__(self, program):
        self.program = program
        self.named = set()  # files of the repository that pages link to

    def link(self, page, target):
        """A link of a page of the repository, as one of the site."""
        if re.match(r"[a-z]+:|#", target):
            return target
        path, hash_, anchor = target.partition("#")
        file = (page.parent / path).resolve()
        if not file.exists():  # made below, or reported by mkdocs
            return target
        place = site_path(file)
        if place.parts[0] == "source":
            self.named.add(file)
        return os.path.relpath(place, site_path(page).parent) + hash_ + anchor

    def convert(self, page):
        """What GitHub and mkdocs read differently: links, info strings, and lists and tables right below a paragraph."""
        lines, fence, above, marker, loose = [], None, "", 0, False
        for line in page.read_text().split("\n"):
            match = pages.FENCE.match(line)
            item = re.match(r"((?:[-*]|\d+\.) +)\S", line) if fence is None else None
            if item:
                marker = len(item[1])
            elif fence is None and line.strip() and not line.startswith(" ") and (match or not above.strip()):
                marker = 0
            if marker and line.startswith(" " * marker):  # mkdocs wants four spaces in the items of a list
                line = "    " + line[marker:]
                match = pages.FENCE.match(line)
            if match and fence is None:
                fence = match[2]
                language, options = pages.options_of(match[3])
                if above.strip():
                    lines.append("")
                title = f' title="{options["file"]}"' if "file" in options else ""
                line = f"{match[1]}{fence}{(language or 'text') + title}"
            elif fence is not None:
                if line.strip() == fence:
                    line += "\n" if match[1] else ""
                    fence = None
            else:
                row = line.startswith("|")
                listed = re.match(r"(?:[-*]|\d+\.) " if loose else r"(?:[-*]|\d+\.) |  +\S", above)
                loose = bool(marker) and not item and (loose or not line.strip())
                if above.strip() and ((item and not listed) or (row and not above.startswith("|"))):
                    lines.append("")
                line = re.sub(r"\]\(([^()\s]+)", lambda match: f"]({self.link(page, match[1])}", line)
                if re.fullmatch(r"!\[[^\]]*\]\([^)]*\)", line):
                    line += "{ loading=lazy }"
            lines.append(line)
            above = line
        return "\n".join(lines)

    def write(self, path, text):
        file = SOURCE / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def run(self, *arguments):
        return subprocess.run([self.program, *arguments], check=True, text=True, capture_output=True).stdout

    def commands(self):
        """The help of every command."""
        text = ["# Commands", "What `tactus COMMAND --help` prints."]

        def add(words):
            printed = "\n".join(wrapped(line) for line in self.run(*words, "--help").split("\n"))
            text.append(f"{'##' if len(words) < 2 else '###'} {' '.join(('tactus', *words))}\n\n```text\n{printed.strip()}\n```")
            listed = printed.partition("Subcommands:")[2].partition("\n\n\n")[0]
            for name in re.findall(r"^  ([a-z-]+)  ", re.split(r"\n\n(?=\S)", listed)[0], re.M):
                add((*words, name))

        add(())
        self.write("reference/commands.md", "\n\n".join(text) + "\n")

    def profiles(self):
        """A table of the shipped actuator profiles."""
        text = ["# Actuator profiles", "The profiles of `instruments/profiles`: the limits that the [drive guard](../drive_guard.md#limits) keeps for each sort of "
                "actuator. The figures are those of the files, which name their sources; take those of your own actuator where you have them."]
        for file in sorted((ROOT / "instruments/profiles").glob("*.toml")):
            self.named.add(file)
            profile = tomllib.loads(file.read_text())
            rows = [f"| `{section}.{key}` | {value} |" for section in ("drive", "heat", "travel", "direct")
                    for key, value in profile.get(section, {}).items()]
            text += [f"## {file.stem}", f"{profile.get('name', '')}. Source: {profile.get('source', 'not given')}. "
                     f"[File](../source/instruments/profiles/{file.name}.txt)", "| limit | value |\n|---|---|\n" + "\n".join(rows)]
        self.write("reference/profiles.md", "\n\n".join(text) + "\n")

    def gallery(self, work):
        """Pictures and sounds, made by the commands that the page of the gallery shows."""
        runner = examples.Examples(self.program, work)
        for fence in pages.fences(GALLERY):
            if fence.language == "sh":
                runner.commands(fence)
        if runner.errors:
            sys.exit("\n".join(runner.errors))
        media = SOURCE / "gallery/media"
        media.mkdir(parents=True)
        made = runner.folders[GALLERY] / "media"
        wanted = {target for _, target in pages.links(GALLERY) if target.startswith("media/")}
        for target in sorted(wanted):
            name = pathlib.Path(target).name
            if name.endswith(".flac"):
                subprocess.run(["flac", "--silent", "--force", "-o", media / name, (made / name).with_suffix(".wav")], check=True,
                               stderr=subprocess.DEVNULL)
            else:
                shutil.copy(made / name, media / name)

    def make(self):
        shutil.rmtree(SOURCE, ignore_errors=True)
        SOURCE.mkdir(parents=True)
        for file in sorted(DOCS.rglob("*")):
            if file.is_file() and file.suffix != ".md":
                place = SOURCE / file.relative_to(DOCS)
                place.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(file, place)
        for page in pages.pages():
            if page != ROOT / "README.md" and str(page.relative_to(ROOT)) != "docs/nodes.md":
                self.write(site_path(page), self.convert(page))
        (DOCS / "nodes.md").exists() or (DOCS / "nodes.md").write_text(self.run("nodes", "--markdown"))
        self.write("nodes.md", self.convert(DOCS / "nodes.md"))
        self.commands()
        self.profiles()
        if GALLERY.exists():
            work = ROOT / "build/site_gallery"
            shutil.rmtree(work, ignore_errors=True)
            work.mkdir()
            self.gallery(work)
            shutil.rmtree(work)
        for file in sorted(self.named):
            if file.is_dir():
                inside = [entry for entry in sorted(file.iterdir()) if entry.is_file()]
                self.write(site_path(file), f"# {file.relative_to(ROOT)}\n\n" + "\n".join(f"- [{entry.name}]({entry.name}.txt)" for entry in inside) + "\n")
                for entry in inside:
                    self.write(site_path(entry), entry.read_text())
            else:
                self.write(site_path(file), file.read_text())


class Page(html.parser.HTMLParser):
    """What a built page links to, what it loads, and its anchors."""

    LOADS = {"script": "src", "img": "src", "audio": "src", "source": "src", "iframe": "src", "video": "src", "embed": "src", "object": "data"}

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.loads = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.ids.add(values.get("id"))
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        if tag == "link" and values.get("rel") not in ("canonical", "prev", "next"):
            self.loads.append(values.get("href", ""))
        if tag in self.LOADS and values.get(self.LOADS[tag]):
            self.loads.append(values[self.LOADS[tag]])
        if "mermaid" in (values.get("class") or "").split():
            self.loads.append("https://unpkg.com/mermaid")  # what the theme's script would load for it


def check_site():
    """(errors, links): links and anchors between the built pages, and anything that is loaded from another server."""
    built = {file: Page(file.read_text()) for file in sorted(SITE.rglob("*.html"))}
    errors, followed = [], 0
    for file, page in built.items():
        place = file.relative_to(SITE)
        for target in [*page.links, *page.loads]:
            url = urllib.parse.urlsplit(target)
            if url.scheme or url.netloc:
                if target in page.loads:
                    errors.append(f"{place}: loads {target}")
                continue
            followed += 1
            aim = (file.parent / urllib.parse.unquote(url.path)).resolve() if url.path else file
            if url.path.startswith("/"):
                aim = SITE / url.path.lstrip("/")
            aim = aim / "index.html" if aim.is_dir() else aim
            if not aim.exists():
                errors.append(f"{place}: '{target}' does not exist")
            elif url.fragment and aim in built and urllib.parse.unquote(url.fragment) not in built[aim].ids:
                errors.append(f"{place}: '{target}' has no such heading")
    for sheet in SITE.rglob("*.css"):
        for target in re.findall(r"(?:url\(|@import\s)[\"']?(https?:)?//", sheet.read_text()):
            errors.append(f"{sheet.relative_to(SITE)}: loads from another server")
    return errors, followed, len(built)


def build(program):
    began = time.monotonic()
    Source(program).make()
    done = subprocess.run(["mkdocs", "build", "--quiet", "--strict", "--clean", "--config-file", ROOT / "mkdocs.yml"])
    if done.returncode:
        print("mkdocs found what is printed above", file=sys.stderr)
        return False
    errors, followed, count = check_site()
    for error in errors:
        print(error, file=sys.stderr)
    size = sum(file.stat().st_size for file in SITE.rglob("*") if file.is_file()) / 1e6
    print(f"build/site: {count} pages, {size:.1f} MB, {followed} links followed, {len(errors)} errors, {time.monotonic() - began:.0f} s")
    return not errors


def newest():
    watched = [ROOT / "mkdocs.yml", ROOT / "CHANGELOG.md", *DOCS.rglob("*"), *ROOT.glob("instruments/*/*")]
    return max(file.stat().st_mtime for file in watched if file.is_file())


def serve(program, port):
    class Handler(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *arguments):
            pass

    server = http.server.ThreadingHTTPServer(("localhost", port), functools.partial(Handler, directory=str(SITE)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    print(f"http://localhost:{port} shows the site; Ctrl-C ends", flush=True)
    seen = newest()
    try:
        while True:
            time.sleep(1)
            if newest() != seen:
                seen = newest()
                build(program)
    except KeyboardInterrupt:
        pass


def main():
    parser = argparse.ArgumentParser(prog="scripts/docs", description="Builds the documentation site in build/site.")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/tactus",
                        help="makes the reference pages and the gallery [build/release/tactus]")
    parser.add_argument("--serve", action="store_true", help="show the site, and build it again when a page changes")
    parser.add_argument("--port", type=int, default=8000, help="of --serve [8000]")
    options = parser.parse_args()
    fine = build(options.program.resolve())
    if options.serve:
        serve(options.program.resolve(), options.port)
    return 0 if fine else 1


if __name__ == "__main__":
    sys.exit(main())
