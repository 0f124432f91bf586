#!/usr/bin/env bash
# Obtains `runner` for run.sh: a given program, or that of a release, whose SHA-256 is verified.
#
# Inputs, by environment:
#   STICTION_RUNNER      a program that exists; nothing is downloaded
#   STICTION_VERSION     tag of a release, such as v0.1.0, or `latest`
#   STICTION_REPOSITORY  OWNER/NAME whose releases are used
#   STICTION_SHA256      expected SHA-256 of the archive; default: that of the release, which detects damage only
#   STICTION_RELEASES    address or mirror of the releases; default: https://github.com/REPOSITORY/releases
#   STICTION_FOLDER      where the archive is unpacked; default: a new folder in RUNNER_TEMP
# Prints the path of the program, and writes the output `runner` where GitHub asks for outputs.
set -euo pipefail

fail() {
    printf 'error: %s\n' "$1" >&2
    exit 2
}

finish() {
    "$1" --version >&2 || fail "$1 cannot be executed"
    if [ -n "${GITHUB_OUTPUT:-}" ]; then
        printf 'runner=%s\n' "$1" >>"$GITHUB_OUTPUT"
    fi
    printf '%s\n' "$1"
    exit 0
}

if [ -n "${STICTION_RUNNER:-}" ]; then
    case $STICTION_RUNNER in
        *$'\n'* | *$'\r'*) fail "the path of the program has a line break" ;;
    esac
    program=$(command -v -- "$STICTION_RUNNER") || fail "there is no program $STICTION_RUNNER"
    case $program in
        /* | [A-Za-z]:*) ;;
        *) program=$PWD/$program ;;
    esac
    finish "$program"
fi

version=${STICTION_VERSION:-latest}
repository=${STICTION_REPOSITORY:-}
# They become parts of an address.
case $version in
    '' | *[!A-Za-z0-9._+-]*) fail "\`$version\` is no tag of a release" ;;
esac
if [ -z "${STICTION_RELEASES:-}" ]; then
    case $repository in
        *[!A-Za-z0-9._/-]* | */*/* | /* | */) fail "\`$repository\` is no repository" ;;
        */*) ;;
        *) fail "\`$repository\` is no repository" ;;
    esac
fi

case $(uname -s)-$(uname -m) in
    Linux-x86_64) target=x86_64-unknown-linux-gnu ;;
    Linux-aarch64 | Linux-arm64) target=aarch64-unknown-linux-gnu ;;
    Darwin-arm64) target=aarch64-apple-darwin ;;
    MINGW*-x86_64 | MSYS*-x86_64) target=x86_64-pc-windows-msvc ;;
    *) fail "there is no archive for $(uname -s) on $(uname -m); build the program and give its path" ;;
esac

releases=${STICTION_RELEASES:-${GITHUB_SERVER_URL:-https://github.com}/$repository/releases}
if [ "$version" = latest ]; then
    address=$releases/latest/download
else
    address=$releases/download/$version
fi
name=stiction-$target
folder=${STICTION_FOLDER:-}
if [ -z "$folder" ]; then
    folder=$(mktemp -d "${RUNNER_TEMP:-${TMPDIR:-/tmp}}/stiction.XXXXXX")
fi
mkdir -p -- "$folder"
# Absolute, as are the outputs. -W: a path of Windows, with a drive.
folder=$(cd -- "$folder" && { pwd -W 2>/dev/null || pwd; })

download() {
    curl --fail --silent --show-error --location --retry 3 --output "$folder/$1" -- "$address/$1" ||
        fail "cannot download $address/$1"
}

download "$name.tar.gz"
expected=${STICTION_SHA256:-}
if [ -z "$expected" ]; then
    download "$name.tar.gz.sha256"
    read -r expected _ <"$folder/$name.tar.gz.sha256" || true
fi
if command -v sha256sum >/dev/null; then
    found=$(sha256sum <"$folder/$name.tar.gz")
else
    found=$(shasum -a 256 <"$folder/$name.tar.gz")
fi
found=${found%% *}
if [ "$found" != "$expected" ]; then
    rm -f -- "$folder/$name.tar.gz"
    fail "SHA-256 of $name.tar.gz is $found, not $expected"
fi

# On Windows `tar` takes C: for a machine, so it reads and unpacks here.
(cd -- "$folder" && tar -xzf "$name.tar.gz")
program=$folder/$name/runner
if [ "$target" = x86_64-pc-windows-msvc ]; then
    program=$program.exe
fi
finish "$program"
