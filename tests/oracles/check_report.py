#!/usr/bin/env python3
"""Opens reports in headless Chromium: each renders, prints nothing to the console, and requests nothing but itself.

    check_report.py REPORT.html...

The browser is $CHROMIUM, or the first of chromium, chromium-browser, google-chrome that is
installed; without one the script prints that it checks nothing. The Python standard library is
enough.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

# The screenshot of a rendered page is larger than five kilobytes, that of an empty page smaller.
DRAWN = 20_000


def browser():
    names = [os.environ.get("CHROMIUM", ""), "chromium", "chromium-browser", "google-chrome"]
    return next((found for found in map(shutil.which, filter(None, names)) if found), None)


def run(program, page, place, *options):
    """Runs the browser on a page with its own profile; returns standard output and error."""
    common = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking",
              "--disable-component-update", "--disable-sync", "--host-resolver-rules=MAP * ~NOTFOUND",
              f"--user-data-dir={place / 'profile'}", "--enable-logging=stderr", "--v=0", "--window-size=1280,2400"]
    done = subprocess.run([program, *common, *options, page.as_uri()], capture_output=True, text=True, timeout=120)
    return done.stdout, done.stderr


def requests(log):
    """Addresses that a page requested. Requests of the browser itself have no page as origin."""
    requested = (line for line in log.read_text(errors="replace").splitlines() if '"initiator":' in line)
    own = (line for line in requested if '"initiator":"not an origin"' not in line)
    return {url for line in own for url in re.findall(r'"url":"([^"]+)"', line)}


def check(program, page):
    """Errors of a page, as text."""
    wrong = []
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        for scheme in ["light", "dark"]:
            picture, log = place / f"{scheme}.png", place / f"{scheme}.json"
            dark = ["--blink-settings=preferredColorScheme=0"] if scheme == "dark" else []
            _, stderr_text = run(program, page, place, f"--screenshot={picture}", f"--log-net-log={log}", *dark)
            wrong += [f"{scheme}, console: {line}" for line in stderr_text.splitlines() if "CONSOLE" in line]
            if not picture.exists() or picture.stat().st_size < DRAWN:
                wrong.append(f"{scheme}: nothing to see")
            wrong += [f"{scheme}, requested {url}" for url in requests(log) if url != page.as_uri()]
        document, _ = run(program, page, place, "--dump-dom")
        source = page.read_text()
        for tag in ["<svg", "<table", "<tr", "<section"]:
            if document.count(tag) != source.count(tag):
                wrong.append(f"{source.count(tag)} {tag}> in the file, {document.count(tag)} in the browser")
        if "<script" in document:
            wrong.append("there is a script")
    return wrong


def main():
    program = browser()
    if program is None:
        print("skipped: no Chromium")
        return 0
    failed = False
    for page in map(lambda p: Path(p).resolve(), sys.argv[1:]):
        wrong = check(program, page)
        failed |= bool(wrong)
        print(f"{page}: {'; '.join(wrong) if wrong else 'good'}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
