"""Inserts the tables of a comparison into docs/engines.md and draws its picture.

    python3 make_page.py FOLDER [MORE...]

FOLDER is the output of `stiction-engines run`. MORE are outputs of engines that have environments of their own; they
have tables of their own.
"""

import sys
from pathlib import Path

from stiction_engines import picture, tables

DOCS = Path(__file__).resolve().parents[1] / "docs"
BEGIN = "<!-- {}: engines/make_page.py -->\n"
END = "<!-- end of {} -->"


def replace(text, name, folders, level):
    """The page with these tables between the marks of a name."""
    before, rest = text.split(BEGIN.format(name))
    after = rest.split(END.format(name))[1]
    body = "\n" + tables.text(folders, 1e-3)
    body = body.replace("\n## ", f"\n{level} ")
    return f"{before}{BEGIN.format(name)}{body}\n{END.format(name)}{after}"


def main(folder, *more):
    page = DOCS / "engines.md"
    text = replace(page.read_text(), "tables", [folder], "###")
    if more:
        text = replace(text, "more tables", list(more), "####")
    page.write_text(text)
    picture.write(folder, DOCS / "pictures/engines.svg")


if __name__ == "__main__":
    main(*sys.argv[1:])
