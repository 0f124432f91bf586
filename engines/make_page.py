"""Inserts the tables of a comparison into docs/engines.md and draws its picture.

    python3 make_page.py FOLDER

FOLDER is the output of `stiction-engines run`.
"""

import sys
from pathlib import Path

from stiction_engines import picture, tables

DOCS = Path(__file__).resolve().parents[1] / "docs"
BEGIN, END = "<!-- tables: engines/make_page.py -->\n", "<!-- end of tables -->"


def main(folder):
    page = DOCS / "engines.md"
    text = page.read_text()
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    body = tables.text(folder, 1e-3).replace("\n## ", "\n### ").replace("## ", "### ", 1)
    page.write_text(f"{before}{BEGIN}\n{body}\n{END}{after}")
    picture.write(folder, DOCS / "pictures/engines.svg")


if __name__ == "__main__":
    main(sys.argv[1])
