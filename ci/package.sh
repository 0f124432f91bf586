#!/usr/bin/env bash
# Makes the archive of a release: the program, its licences, the scripts of continuous integration, and a SHA-256.
#
#     ci/package.sh TARGET PROGRAM FOLDER
#
# writes FOLDER/stiction-TARGET.tar.gz and .tar.gz.sha256. Names have no version, so that `releases/latest` works.
set -euo pipefail

target=$1
program=$2
folder=$3
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
name=stiction-$target

mkdir -p "$folder/$name/ci"
cp "$program" "$folder/$name/"
cp "$root/LICENSE-MIT" "$root/LICENSE-APACHE" "$root/README.md" "$folder/$name/"
cp "$root/src/view/page/three/LICENSE" "$folder/$name/LICENSE-three.js"
cp "$root/ci/run.sh" "$root/ci/summary.py" "$folder/$name/ci/"
"${PYTHON:-python3}" "$root/ci/licences.py" "$target" >"$folder/$name/LICENSES-dependencies.txt"

cd "$folder"
tar -czf "$name.tar.gz" "$name"
rm -r "$name"
if command -v sha256sum >/dev/null; then
    sha256sum "$name.tar.gz" >"$name.tar.gz.sha256"
else
    shasum -a 256 "$name.tar.gz" >"$name.tar.gz.sha256"
fi
cat "$name.tar.gz.sha256"
