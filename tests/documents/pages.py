"""What a page of the documentation is made of: fenced blocks with a language, links, and lines of a terminal."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
# python is executed; output is what the block before it prints; sh and console are typed into a terminal.
LANGUAGES = ("python", "output", "console", "sh", "toml", "text")


@dataclass(frozen=True)
class Block:
    """A fenced block.

    Attributes:
        language: the word behind the fence.
        line: number of the line with the fence, from 1.
        text: what stands between the fences.
    """

    language: str
    line: int
    text: str

    @property
    def file(self) -> str | None:
        """Name of the file that the block is, if its first line says `# file: name`."""
        found = re.match(r"# file: (\S+)\n", self.text)
        return found.group(1) if found else None


def name_of(page: Path) -> str:
    """The page, for messages."""
    return page.relative_to(ROOT).as_posix()


def blocks(page: Path) -> list[Block]:
    """The fenced blocks of a page, in order.

    Raises:
        AssertionError: on a fence without or with another language than those above, or one that is not closed.
    """
    found: list[Block] = []
    language, begin, lines = None, 0, list[str]()
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if not line.lstrip().startswith("```"):
            lines.append(line)
        elif language is None:
            language, begin, lines = line[3:].strip(), number, []
            where = f"{name_of(page)}:{number}"
            assert line.startswith("```"), f"{where}: an indented fence"
            assert language in LANGUAGES, f"{where}: '{language}' must be one of {', '.join(LANGUAGES)}"
        else:
            found.append(Block(language, begin, "\n".join(lines) + "\n"))
            language = None
    assert language is None, f"{name_of(page)}:{begin}: this block is not closed"
    return found


def commands(page: Path) -> list[tuple[str, list[str]]]:
    """(page:line, words) of every `rbs ...` command of a page; `&&`, `$` and NAME=value in front are left out."""
    found = []
    for block in blocks(page):
        if block.language not in ("console", "sh"):
            continue
        for number, line in enumerate(block.text.splitlines(), block.line + 1):
            for command in line.removeprefix("$ ").split("&&"):
                words = shlex.split(command, comments=True)
                while words and re.match(r"[A-Z_]+=", words[0]):
                    words.pop(0)
                if words and words[0] == "rbs":
                    found.append((f"{name_of(page)}:{number}", words))
    return found


def prose(page: Path) -> str:
    """A page without its blocks."""
    return re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def links(page: Path) -> list[str]:
    """Targets of the links of a page that lead to files of the project, with their anchors."""
    return [target for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)) if "://" not in target]


def pictures(page: Path) -> list[Path]:
    """The pictures of a page."""
    targets = re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", prose(page))
    return [(page.parent / target).resolve() for target in targets if "://" not in target]


def leads_somewhere(page: Path, target: str) -> bool:
    """True if the file of a link exists, and the heading that its anchor names."""
    name, _, anchor = target.partition("#")
    file = (page.parent / name).resolve() if name else page
    if not anchor or not file.exists():
        return file.exists()
    headings = re.findall(r"^#+ (.*)$", prose(file), flags=re.MULTILINE)
    return anchor in {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def paths(page: Path) -> list[str]:
    """Names of files and folders of the project that a page mentions between backticks."""
    text = page.read_text(encoding="utf-8")
    return re.findall(r"`((?:rbs_core|rbs_plugins|simulations|tests|docs|\.ci)/[\w./-]*)`", text)
