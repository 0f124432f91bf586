#!/usr/bin/env bash
# Runs scenarios in continuous integration: JUnit XML, a summary in Markdown, the comparison with earlier results.
# Exits with the code of `runner run` after all files are written. Works with bash 3.2, which macOS has.
#
# Inputs, all by environment; lists have one entry per line, so that names may contain spaces:
#   STICTION_RUNNER             the program; default: runner
#   STICTION_SCENARIOS          files, folders and patterns
#   STICTION_ARGUMENTS          options of `runner run`, a value after a space or `=`: --timeout 300
#   STICTION_SET                KEY=VALUE, as for --set
#   STICTION_JOBS               parallel runs
#   STICTION_OUTPUT             folder of results; default: results
#   STICTION_BASELINE           folder of earlier results
#   STICTION_HISTORY            history of results, to which these are appended after the comparison; instead of a baseline
#   STICTION_LABEL              name of the results in the history; default: the commit that the server names
#   STICTION_COMPARE_ARGUMENTS  options of `runner compare`
# Writes junit.xml, messages.jsonl, summary.md and compare.json in the folder of results, and, where GitHub gives them,
# to GITHUB_OUTPUT and GITHUB_STEP_SUMMARY.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
runner=${STICTION_RUNNER:-runner}
output=${STICTION_OUTPUT:-results}
baseline=${STICTION_BASELINE:-}
history=${STICTION_HISTORY:-}
label=${STICTION_LABEL:-${GITHUB_SHA:-${CI_COMMIT_SHA:-}}}
github=${GITHUB_ACTIONS:-}

set_output() {
    if [ -n "${GITHUB_OUTPUT:-}" ]; then
        printf '%s=%s\n' "$1" "$2" >>"$GITHUB_OUTPUT"
    fi
}

# Invalid input: the code that the program has for it.
fail() {
    printf 'error: %s\n' "$1" >&2
    set_output exit-code 2
    exit 2
}

# Lines without surrounding blanks and without empty ones, in the array `lines`.
read_lines() {
    local line
    lines=()
    while IFS= read -r line || [ -n "$line" ]; do
        line=${line#"${line%%[![:space:]]*}"}
        line=${line%"${line##*[![:space:]]}"}
        if [ -n "$line" ]; then
            lines+=("$line")
        fi
    done <<<"$1"
}

# Options, one per line, in the array `options`: the first blank ends the name, the rest is the value as it is.
read_options() {
    local line
    options=()
    read_lines "$2"
    for line in ${lines[@]+"${lines[@]}"}; do
        case $line in
            -*[[:space:]]*)
                options+=("${line%%[[:space:]]*}")
                line=${line#*[[:space:]]}
                options+=("${line#"${line%%[![:space:]]*}"}")
                ;;
            -*) options+=("$line") ;;
            *) fail "$1: \`$line\` is not an option; give one option per line" ;;
        esac
    done
}

# Outputs and paths are single lines: a line break would add outputs.
single_line() {
    case $2 in
        *$'\n'* | *$'\r'*) fail "$1 has a line break" ;;
    esac
}

single_line output "$output"
single_line baseline "$baseline"
single_line history "$history"
single_line label "$label"
single_line jobs "${STICTION_JOBS:-}"

arguments=()
read_options arguments "${STICTION_ARGUMENTS:-}"
arguments+=(${options[@]+"${options[@]}"})
read_options compare-arguments "${STICTION_COMPARE_ARGUMENTS:-}"
compare_arguments=(${options[@]+"${options[@]}"})
read_lines "${STICTION_SET:-}"
for line in ${lines[@]+"${lines[@]}"}; do
    arguments+=("--set=$line")
done
if [ -n "${STICTION_JOBS:-}" ]; then
    arguments+=("--jobs=$STICTION_JOBS")
fi

# Patterns are expanded without splitting at blanks. One without a match stays, and the program reports it.
scenarios=()
read_lines "${STICTION_SCENARIOS:-}"
for line in ${lines[@]+"${lines[@]}"}; do
    if [ -e "$line" ]; then
        scenarios+=("$line")
    else
        IFS=
        # shellcheck disable=SC2206
        scenarios+=($line)
        unset IFS
    fi
done
if [ ${#scenarios[@]} -eq 0 ]; then
    fail "no scenarios are given"
fi
if [ -n "$baseline" ] && [ -n "$history" ]; then
    fail "baseline and history are given; the history is the baseline"
fi

command -v -- "$runner" >/dev/null || fail "there is no program $runner"

mkdir -p -- "$output" || fail "cannot create the folder $output"
junit=$output/junit.xml
messages=$output/messages.jsonl
compared=$output/compare.json
summary=$output/summary.md
# Files of an earlier batch in the same folder are not reported as those of this one, and links are not followed.
rm -f -- "$junit" "$messages" "$compared" "$summary"
: >"$messages" || fail "cannot write $messages"

# The log shows texts of scenarios: no line of it is a command to GitHub.
if [ -n "$github" ]; then
    token=$(od -An -N16 -tx1 /dev/urandom | tr -d ' \n')
    printf '::stop-commands::%s\n' "$token"
fi

# In the background, so that a signal reaches the program, which then completes its files.
"$runner" run --message-format=json --output="$output" --junit="$junit" ${arguments[@]+"${arguments[@]}"} \
    -- "${scenarios[@]}" >"$messages" &
child=$!
trap 'signalled=1; kill -TERM "$child" 2>/dev/null || true' INT TERM
signalled=1
while [ "$signalled" = 1 ]; do
    # A signal ends `wait` early, with a code that is not the program's.
    signalled=0
    code=0
    wait "$child" || code=$?
done
trap - INT TERM

# Only results of this batch: invalid input leaves those of an earlier one.
attempted=()
if [ -n "$baseline$history" ] && [ -f "$junit" ]; then
    attempted=("--baseline=$baseline$history")
    against=("--baseline=$baseline$history")
    if [ -n "$history" ]; then
        against+=(--append "--label=$label")
    fi
    # A history is created.
    if [ -n "$history" ] || [ -e "$baseline" ]; then
        compare_code=0
        "$runner" compare --format=json "${against[@]}" ${compare_arguments[@]+"${compare_arguments[@]}"} \
            -- "$output" >"$compared" || compare_code=$?
        attempted+=("--compare-code=$compare_code")
    fi
fi

if [ -n "$github" ]; then
    printf '::%s::\n' "$token"
fi

python=
for candidate in "${PYTHON:-python3}" python; do
    if "$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 8))' >/dev/null 2>&1; then
        python=$candidate
        break
    fi
done
if [ -n "$python" ]; then
    # An error in the summary does not hide the outcome.
    "$python" "$here/summary.py" --messages="$messages" --compare="$compared" --output="$output" --exit-code="$code" \
        ${attempted[@]+"${attempted[@]}"} || printf 'warning: no summary was written\n' >&2
    if [ -f "$summary" ] && [ -n "${GITHUB_STEP_SUMMARY:-}" ]; then
        cat -- "$summary" >>"$GITHUB_STEP_SUMMARY"
    fi
else
    printf 'warning: no summary, as there is no Python 3.8 or newer\n' >&2
fi

set_output exit-code "$code"
set_output messages "$messages"
if [ -f "$junit" ]; then
    set_output junit "$junit"
fi
if [ -f "$summary" ]; then
    set_output summary "$summary"
fi
exit "$code"
