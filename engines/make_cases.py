"""Writes the cases of stiction_engines/cases: JSON, URDF and the index.

    python3 make_cases.py [--check]

Every truth is computed here from the numbers of the case. `--check` writes nothing and fails if a file would change.
Needs mpmath; references of robots are read from references.json, which make_references.py wrote.
"""

import argparse
import json
import shutil
import sys
import tempfile
from pathlib import Path

from case_families import articulated, breakaway, falling, flight, rolling, sliding, slopes, stacked, tipping

FAMILIES = [sliding, slopes, breakaway, falling, tipping, rolling, stacked, flight, articulated]
CASES = Path(__file__).parent / "stiction_engines" / "cases"


def write(folder):
    folder.mkdir(parents=True, exist_ok=True)
    index = []
    for family in FAMILIES:
        for case, urdfs in family.cases():
            for name, text in urdfs.items():
                (folder / name).write_text(text)
            (folder / f"{case['name']}.json").write_text(json.dumps(case, indent=1) + "\n")
            index.append(case["name"])
    repeated = {name for name in index if index.count(name) > 1}
    assert not repeated, repeated


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="compare with the files of the tree")
    check = parser.parse_args().check
    fresh = Path(tempfile.mkdtemp())
    write(fresh)
    kept = {"case.schema.json"}
    files = lambda folder: {p.name: p.read_text() for p in folder.iterdir() if p.name not in kept}
    if check:
        new, old = files(fresh), files(CASES)
        differ = sorted(name for name in new.keys() | old.keys() if new.get(name) != old.get(name))
        if differ:
            sys.exit(f"not as make_cases.py writes them: {', '.join(differ)}")
        return
    for path in CASES.iterdir() if CASES.exists() else []:
        if path.name not in kept:
            path.unlink()
    CASES.mkdir(exist_ok=True)
    for path in fresh.iterdir():
        shutil.copy(path, CASES / path.name)
    print(f"{len(list(CASES.glob('*.json')))} cases in {CASES}")


if __name__ == "__main__":
    main()
