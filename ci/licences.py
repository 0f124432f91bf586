"""Prints the licence texts of all crates that are compiled into `runner`.

    licences.py TARGET

Their licences require that copies of the program carry these texts.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FILE = re.compile(r"(licen[cs]e|copying|notice|unlicense)", re.IGNORECASE)
CODE = {".rs", ".h", ".c", ".py"}
# Parts of C sources that are not compiled.
UNUSED = {"tests", "examples", "programs", "contrib", "doc"}


def dependencies(target):
    """Packages that `runner` needs at run time, by name and version."""
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    root = next(id for id, package in packages.items() if Path(package["manifest_path"]) == ROOT / "Cargo.toml")
    found, left = set(), [root]
    while left:
        id = left.pop()
        if id in found:
            continue
        found.add(id)
        for needed in nodes[id]["deps"]:
            # Build dependencies are included: those with C sources, such as Luau's, are compiled along.
            if any(kind["kind"] in (None, "build") for kind in needed["dep_kinds"]):
                left.append(needed["pkg"])
    # Packages without a source are those of this repository.
    found = {id for id in found if packages[id]["source"]}
    return sorted((packages[id] for id in found), key=lambda package: (package["name"], package["version"]))


def texts(package):
    """Licence files of a package and of sources that it brings, at most two folders deep."""
    folder = Path(package["manifest_path"]).parent
    for pattern in ("*", "*/*", "*/*/*"):
        for path in sorted(folder.glob(pattern)):
            between = path.relative_to(folder).parts[:-1]
            licence = FILE.match(path.name) and path.suffix not in CODE and path.is_file()
            if licence and not UNUSED & set(between):
                yield path.relative_to(folder), path.read_text(encoding="utf-8", errors="replace").strip()


def main():
    sys.stdout.reconfigure(encoding="utf-8")
    owners = {}
    lacking = []
    for package in dependencies(sys.argv[1]):
        name = f"{package['name']} {package['version']} ({package['license']})"
        found = False
        for path, text in texts(package):
            owners.setdefault(text, []).append(f"{name}: {path.as_posix()}")
            found = True
        if not found:
            lacking.append(f"{name} {package['repository'] or ''}".strip())
    print("Licences of the crates that are compiled into the program.\n")
    if "linux-gnu" in sys.argv[1]:
        print("The program also contains parts of the GNU C library (LGPL-2.1-or-later) and of libstdc++ and libgcc")
        print("(GPL-3.0-or-later with the GCC Runtime Library Exception). The sources of this project and Cargo.lock")
        print("suffice to link it with other versions of them.\n")
    if lacking:
        print("Without a licence text in their package:\n")
        print("\n".join(lacking))
    for text, names in owners.items():
        print("\n" + "=" * 80)
        print("\n".join(names))
        print("=" * 80 + "\n")
        print(text)


if __name__ == "__main__":
    main()
