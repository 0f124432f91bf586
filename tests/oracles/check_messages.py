#!/usr/bin/env python3
"""Checks the machine-readable output of a batch: the lines of `--message-format json` and the file of `--junit`.

    check_messages.py MESSAGES JUNIT SCHEMA RUNS

Checked:

- every line is a message of the schema: by the package `jsonschema` if it is installed, otherwise
  only that its event is known and its required fields are present;
- the batch begins and ends;
- RUNS runs other than references are reported and have a case each;
- both files agree on the runs that failed.

The Python standard library is enough.
"""

import json
import sys
import xml.etree.ElementTree as xml
from pathlib import Path


def validator(schema):
    """Returns a function that describes the error of a line, and the name of the validator used."""
    try:
        import jsonschema
    except ImportError:
        variants = {v["properties"]["event"]["const"]: v for v in schema["oneOf"]}

        def problem(line):
            variant = variants.get(line.get("event"))
            if variant is None:
                return f"unknown event {line.get('event')}"
            parts = [schema, variant]
            if "$ref" in variant:
                part = schema
                for name in variant["$ref"].removeprefix("#/").split("/"):
                    part = part[name]
                parts.append(part)
            missing = [name for part in parts for name in part.get("required", []) if name not in line]
            return f"{line['event']} lacks {missing}" if missing else None

        return problem, "by required fields"
    draft = jsonschema.Draft202012Validator(schema)

    def problem(line):
        error = next(draft.iter_errors(line), None)
        return f"{line.get('event')}: {error.message[:300]}" if error else None

    return problem, "by jsonschema"


def main(messages, junit, schema, runs):
    problem, how = validator(json.loads(Path(schema).read_text()))
    lines = [json.loads(line) for line in Path(messages).read_text().splitlines()]
    wrong = [error for error in map(problem, lines) if error]
    events = [line["event"] for line in lines]
    if "batch-started" not in events or events[-1] != "batch-finished":
        wrong.append("the batch does not begin or does not end")
    finished = [line for line in lines if line["event"] == "run-finished"]
    cases = list(xml.parse(junit).getroot().iter("testcase"))
    own = sum(not line["reference"] for line in finished)
    if own != int(runs) or len(cases) != len(finished):
        wrong.append(f"{own} runs reported, {len(finished)} with references, {len(cases)} cases; there are {runs}")
    refused = sum(not line["accepted"] for line in finished)
    failed = sum(case.find("failure") is not None or case.find("error") is not None for case in cases)
    if refused != failed:
        wrong.append(f"{refused} runs not accepted, {failed} cases failed")
    print("; ".join(wrong[:10]) if wrong else f"good: {len(lines)} messages ({how}), {len(cases)} cases, {failed} failed")
    return int(bool(wrong))


if __name__ == "__main__":
    if len(sys.argv) != 5:
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    sys.exit(main(*sys.argv[1:]))
