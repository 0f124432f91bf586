"""run.sh as a step of a job: codes, outputs, summary, hostile input."""

import json
import os
import signal
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree as ElementTree

from support import ROOT, RUNNER, Case, cells, need_program, scenario


class Outcomes(Case):
    def test_all_pass(self):
        self.write("slide.toml", scenario())
        step = self.run_step()
        self.assertEqual(step.code, 0, step.stderr)
        self.assertEqual(
            step.outputs,
            {
                "exit-code": "0",
                "failed-runs": "0",
                "changed": "",
                "messages": "results/messages.jsonl",
                "junit": "results/junit.xml",
                "summary": "results/summary.md",
            },
        )
        self.assertIn("1 run, all as expected", step.summary)
        self.assertEqual(cells(step.summary, "`slide`")[0][1:4], ["1", "1 passed", "2 of 2"])
        self.assertNotIn("baseline", step.summary)
        self.assertNotIn("::error", step.stdout)
        self.assertEqual((self.work / "results/summary.md").read_text(encoding="utf-8"), step.summary)

    def test_failed_expectation_is_named(self):
        self.write("slide.toml", scenario(friction=0.4))
        self.write("holds.toml", scenario())
        step = self.run_step()
        self.assertEqual(step.code, 1, step.stderr)
        self.assertEqual(step.outputs["exit-code"], "1")
        self.assertEqual(step.outputs["failed-runs"], "1")
        self.assertIn("1 of 2 runs failed", step.summary)
        self.assertEqual(cells(step.summary, "`slide`")[0][1:4], ["1", "**1 failed**", "1 of 2"])
        # 4 / (2 * 0.4 * 9.81) = 0.509684 m, 0.101937 m too far.
        failed = cells(step.summary, "`slide`")[1]
        self.assertEqual(failed, ["`slide`", "`final_base_x`", "0.509684", "0.407747 ± 1e-9", "0.102"])
        self.assertIn("::error file=slide.toml,title=slide%3A failed::final_base_x is 0.50968", step.stdout)

    def test_junit_names_the_failure(self):
        self.write("slide.toml", scenario(friction=0.4))
        step = self.run_step()
        root = ElementTree.parse(self.work / step.outputs["junit"]).getroot()
        (failure,) = root.iter("failure")
        self.assertEqual(failure.get("type"), "expectation")

    def test_failed_scenario_comes_first(self):
        self.write("a.toml", scenario())
        self.write("b.toml", scenario(friction=0.4))
        summary = self.run_step().summary
        self.assertLess(summary.index("`b`"), summary.index("`a`"))

    def test_invalid_scenario(self):
        self.write("slide.toml", scenario() + "frikton = 1\n")
        step = self.run_step()
        self.assertEqual(step.code, 2)
        self.assertEqual(step.outputs["exit-code"], "2")
        self.assertEqual(step.outputs["failed-runs"], "0")
        self.assertNotIn("junit", step.outputs)
        self.assertIn("nothing was run", step.summary)
        self.assertIn("unknown key `frikton`", step.summary)
        self.assertIn("::error file=slide.toml,line=8,col=1::unknown key `frikton`", step.stdout)

    def test_unmatched_pattern(self):
        step = self.run_step("none*.toml")
        self.assertEqual(step.code, 2)
        self.assertIn("none*.toml", step.summary)

    def test_nothing_selected(self):
        self.write("slide.toml", scenario())
        step = self.run_step(arguments="--filter duration > 5")
        self.assertEqual((step.code, step.outputs["exit-code"]), (4, "4"))
        self.assertIn("the filter holds for none of 1 run", step.summary)

    def test_run_that_does_not_finish(self):
        self.write("slide.toml", scenario())
        step = self.run_step(arguments="--no-timing\n--timeout 0.000001")
        self.assertEqual(step.code, 3, step.stderr)
        self.assertEqual(step.outputs["failed-runs"], "1")
        self.assertIn("#### Runs that did not finish", step.summary)
        self.assertIn("`timed-out`", step.summary)

    def test_wrong_usage(self):
        self.write("slide.toml", scenario())
        step = self.run_step(arguments="--bogus")
        self.assertEqual(step.code, 2)
        self.assertEqual(step.outputs["exit-code"], "2")
        self.assertIn("wrote no messages", step.summary)

    def test_results_of_an_earlier_step_are_not_reported(self):
        path = self.write("slide.toml", scenario())
        self.assertEqual(self.run_step().code, 0)
        path.write_text("nonsense", encoding="utf-8")
        step = self.run_step()
        self.assertEqual(step.code, 2)
        self.assertNotIn("junit", step.outputs)
        self.assertFalse((self.work / "results/junit.xml").exists())

    def test_signal_completes_the_files(self):
        """As when a job is cancelled."""
        self.write("slide.toml", scenario() + "sweep = { repeat = 9000 }\n")
        environment = self.environment(True, {"scenarios": "slide.toml", "arguments": "--no-timing\n--no-log"})
        log = open(self.folder / "log", "w", encoding="utf-8")
        process = subprocess.Popen(
            ["bash", str(ROOT / "ci/run.sh")], cwd=self.work, env=environment, stdout=log, stderr=log
        )
        runs = self.work / "results/runs.jsonl"
        deadline = time.monotonic() + 60
        while not (runs.exists() and runs.stat().st_size) and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        code = process.wait(60)
        log.close()
        text = (self.folder / "log").read_text(encoding="utf-8")
        self.assertEqual(code, 143, text)
        self.assertIn("exit-code=143", (self.folder / "output").read_text(encoding="utf-8"))
        self.assertIn("not started", (self.folder / "summary").read_text(encoding="utf-8"))
        self.assertTrue((self.work / "results/junit.xml").exists())


class Inputs(Case):
    def test_names_with_blanks(self):
        self.write("my scenarios/first slide.toml", scenario())
        self.write("my scenarios/second slide.toml", scenario())
        self.write("other folder/third.toml", scenario())
        step = self.run_step("  my scenarios/*slide.toml  \n\nother folder\r\n", output="my results", jobs="1")
        self.assertEqual(step.code, 0, step.stderr)
        self.assertEqual(step.outputs["junit"], "my results/junit.xml")
        for name in ("`first slide`", "`second slide`", "`third`"):
            self.assertEqual(len(cells(step.summary, name)), 1)

    def test_name_that_is_a_pattern(self):
        self.write("a[1].toml", scenario())
        self.write("a1.toml", "nonsense")
        self.assertEqual(self.run_step("a[1].toml").code, 0)

    def test_name_like_an_option(self):
        self.write("--bogus.toml", scenario())
        self.assertEqual(self.run_step("--bogus.toml").code, 0)

    def test_values_are_set(self):
        self.write("slide.toml", scenario())
        step = self.run_step(set="\n  floor.friction=0.4\n\nrobot.base.linear_velocity = [1, 0, 0]\n")
        self.assertEqual(step.code, 1, step.stderr)
        # 1 / (2 * 0.4 * 9.81) m.
        self.assertEqual(cells(step.summary, "`slide`")[1][2], "0.127421")

    def test_values_of_options_are_not_split(self):
        self.write("slide.toml", scenario())
        self.write("other.toml", scenario())
        step = self.run_step(arguments='--no-timing\n  --filter   name ~ "sl*" and duration < 5\n--timeout=300')
        self.assertEqual(step.code, 0, step.stderr)
        self.assertIn("1 run, all as expected", step.summary)

    def test_arguments_are_options(self):
        self.write("slide.toml", scenario())
        step = self.run_step(arguments="slide.toml")
        self.assertEqual((step.code, step.outputs["exit-code"]), (2, "2"))
        self.assertIn("is not an option", step.stderr)

    def test_options_of_the_script_are_not_replaced(self):
        self.write("slide.toml", scenario())
        for option in ("--output other", "--junit=other.xml", "--message-format human"):
            self.assertEqual(self.run_step(arguments=option).code, 2, option)
            self.assertEqual(self.files(), ["slide.toml"])

    def test_no_scenarios(self):
        self.assertEqual(self.run_step("  \n\n").code, 2)

    def test_no_program(self):
        step = self.run_step("a.toml", runner="missing/runner")
        self.assertEqual((step.code, step.outputs["exit-code"]), (2, "2"))

    def test_outside_of_github(self):
        self.write("slide.toml", scenario(friction=0.4))
        step = self.run_step(github=False)
        self.assertEqual(step.code, 1)
        self.assertEqual(step.stdout, "")
        self.assertTrue((self.work / "results/summary.md").exists())

    def test_without_python(self):
        """The code and JUnit XML do not need it."""
        tools = self.folder / "tools"
        tools.mkdir()
        for name in ("bash", "dirname", "mkdir", "rm", "od", "tr", "cat"):
            need_program(name)
            path = next(p for p in os.environ["PATH"].split(os.pathsep) if os.access(os.path.join(p, name), os.X_OK))
            (tools / name).symlink_to(os.path.join(path, name))
        self.write("slide.toml", scenario(friction=0.4))
        environment = self.environment(True, {"scenarios": "slide.toml", "arguments": "--no-timing"})
        del environment["PYTHON"]
        environment["PATH"] = str(tools)
        process = subprocess.run(
            [str(tools / "bash"), str(ROOT / "ci/run.sh")],
            cwd=self.work,
            env=environment,
            capture_output=True,
            encoding="utf-8",
        )
        self.assertEqual(process.returncode, 1, process.stderr)
        self.assertIn("no Python", process.stderr)
        self.assertIn("junit=results/junit.xml", (self.folder / "output").read_text(encoding="utf-8"))


class Claims(Case):
    def test_verdicts_are_listed_with_bounds(self):
        # Distances are v^2 / (2 mu g) with v of 2 m/s in all runs.
        claims = """sweep = { repeat = 6 }
claim = [
    { name = "far", quantile = 0.5, metric = "final_base_x", at_least = 0.3 },
    { name = "near | *all*", quantile = 0.5, metric = "final_base_x", at_most = 0.3 },
    { name = "often", share = { outcome = "passed" }, at_least = 0.9 },
]
"""
        self.write("slide.toml", scenario() + claims)
        step = self.run_step()
        self.assertEqual(step.code, 1, step.stderr)
        self.assertIn("#### Claims\n", step.summary)
        rows = cells(step.summary.replace("\\|", "!"), "`slide: far`")
        self.assertEqual([row[1] for row in rows], ["holds"])
        # All six values are equal.
        self.assertEqual(rows[0][2:], ["`0.5 quantile of final_base_x at least 0.3`", "0.408", "0.408", "0.408", "6 of 6"])
        self.assertEqual(cells(step.summary.replace("\\|", "!"), "`slide: near ! *all*`")[0][1], "fails")
        # P(X <= 6) is 1: the lower bound is 0.05^(1/6).
        often = cells(step.summary, "`slide: often`")[0]
        self.assertEqual(often[1:2] + often[3:], ["undecided", "1", "0.607", "1", "6 of 6"])

    def test_no_claims(self):
        self.write("slide.toml", scenario())
        self.assertNotIn("Claims", self.run_step().summary)


class Searches(Case):
    # Without expectations.
    BLOCK = scenario().split("expect")[0]
    SEARCH = """[search]
boundary = { metric = "final_base_x", min = 0.3 }
over = { "robot.base.linear_velocity.0" = { between = [1, 2], tolerance = 0.01 } }
[sweep]
grid = { "floor.friction" = [0.4, 0.5] }
"""

    def test_boundaries_are_listed(self):
        # v^2 / (2 mu g) = 0.3 m: 1.534 m/s and 1.716 m/s.
        self.write("slide.toml", self.BLOCK + self.SEARCH)
        step = self.run_step()
        self.assertEqual(step.code, 0, step.stderr)
        self.assertIn("#### Searches\n", step.summary)
        name = "`slide: final_base_x at least 0.3 [floor.friction={}]`"
        for friction, found in (0.4, "1.53 to 1.54, holds above"), (0.5, "1.71 to 1.72, holds above"):
            row = cells(step.summary, name.format(friction))[0]
            self.assertEqual(row[1:4], ["found", "`robot.base.linear_velocity.0`", f"`{found}`"])

    def test_best_values_and_none_are_listed(self):
        best = self.SEARCH.replace('boundary = { metric = "final_base_x", min = 0.3 }', 'maximize = "final_base_x"\nruns = 60')
        self.write("slide.toml", self.BLOCK + best)
        step = self.run_step()
        row = cells(step.summary, "`slide: greatest final_base_x [floor.friction=0.5]`")[0]
        self.assertEqual(row[1:4], ["found", "`robot.base.linear_velocity.0`", "`0.407747 at robot.base.linear_velocity.0 = 2`"])
        self.write("slide.toml", self.BLOCK + self.SEARCH.replace("0.3", "9.0"))
        step = self.run_step()
        self.assertEqual(step.code, 5, step.stderr)
        self.assertIn("a search has no result", step.summary)
        self.assertEqual(cells(step.summary, "`slide: final_base_x at least 9 [floor.friction=0.4]`")[0][1], "no-boundary")


    def test_moved_boundaries_are_compared(self):
        path = self.write("slide.toml", self.BLOCK + self.SEARCH)
        self.run_step(output="before")
        path.write_text((self.BLOCK + self.SEARCH).replace("duration = 1.0", "duration = 0.3"), encoding="utf-8")
        step = self.run_step(baseline="before")
        self.assertGreaterEqual(int(step.outputs["changed"]), 2)
        # After 0.3 s, v t - mu g t^2 / 2 = 0.3 m: 1.589 m/s.
        name = "`slide floor.friction=0.4: final_base_x at least 0.3 over robot.base.linear_velocity.0`"
        self.assertEqual(cells(step.summary, name)[0][1:], ["`found 1.53 to 1.54`", "`found 1.58 to 1.59`"])


class History(Case):
    CLAIM = """sweep = { repeat = 5 }
claim = [{ name = "stays", change = "final_base_x", at_most = 0.05 }]
"""

    def test_results_are_appended_and_compared(self):
        path = self.write("slide.toml", scenario() + self.CLAIM)
        step = self.run_step(history="kept/h.parquet", label="v1")
        self.assertEqual((step.code, step.outputs["changed"]), (0, "0"), step.stderr)
        self.assertIn("The history has no other results yet.", step.summary)
        self.assertNotIn("Claims about changes", step.summary)
        path.write_text(scenario(friction=0.4) + self.CLAIM, encoding="utf-8")
        step = self.run_step(history="kept/h.parquet", label="v2", compare_arguments="--absolute 1\n--threshold evaluations=inf")
        # An outcome of each run, and the claim: 0.102 m farther.
        self.assertEqual((step.code, step.outputs["changed"]), (1, "6"), step.summary)
        self.assertIn("#### Claims about changes\n", step.summary)
        statement = "`median of the change of final_base_x against the baseline at most 0.05`"
        self.assertEqual(
            cells(step.summary, "`slide: stays`")[0][1:], ["fails", statement, "0.102", "0.102", "0.102", "5 of 5"]
        )
        compared = json.loads((self.work / "results/compare.json").read_text(encoding="utf-8"))
        self.assertEqual(compared["results"][0]["appended"], {"state": "new", "results": 2, "rows": 10, "removed": 0})

    def test_trends_are_listed(self):
        # 4e-7 m farther each time, and 3e-6 m in all.
        for i in range(8):
            self.write("slide.toml", scenario(friction=0.5 * (1 - 1e-6 * i)))
            step = self.run_step(history="kept", compare_arguments="--threshold final_base_x=1e-6")
        compared = json.loads((self.work / "results/compare.json").read_text(encoding="utf-8"))
        trends = [s for s in compared["results"][0]["history"]["series"] if s["trend"]["is_shown"]]
        self.assertIn("final_base_x", [series["column"] for series in trends])
        rows = [row for row in cells(step.summary, "`slide`") if len(row) == 7]
        self.assertEqual([row[1] for row in rows], [f"`{series['column']}`" for series in trends])
        # 2 / 8!
        self.assertEqual({(row[5], row[6]) for row in rows if row[1] == "`final_base_x`"}, {("rises", "5e-5")})

    def test_a_history_is_the_baseline(self):
        self.write("slide.toml", scenario())
        step = self.run_step(history="h", baseline="b")
        self.assertEqual((step.code, step.outputs), (2, {"exit-code": "2"}))


class Baseline(Case):
    def test_changed_metrics_are_listed(self):
        path = self.write("slide.toml", scenario())
        self.assertEqual(self.run_step(output="before").code, 0)
        path.write_text(scenario(friction=0.4), encoding="utf-8")
        step = self.run_step(baseline="before")
        self.assertEqual(step.code, 1)
        self.assertGreater(int(step.outputs["changed"]), 1)
        rows = cells(step.summary, "`slide`")
        self.assertIn(["`slide`", "`passed`", "`failed`"], rows)
        # mu g instead of 0.5 g: 1 / 0.8 of the distance.
        self.assertIn(["`slide`", "`final_base_x`", "0.407747", "0.509684", "+0.102", "+25 %"], rows)
        relative = [abs(float(row[5].split()[0])) for row in rows if len(row) == 6 and row[5].endswith("%")]
        self.assertEqual(relative, sorted(relative, reverse=True))

    def test_no_change(self):
        self.write("slide.toml", scenario())
        self.run_step(output="before")
        step = self.run_step(baseline="before")
        self.assertEqual((step.code, step.outputs["changed"]), (0, "0"))
        self.assertIn("no change beyond tolerance", step.summary)

    def test_tolerances(self):
        path = self.write("slide.toml", scenario())
        self.run_step(output="before")
        path.write_text(scenario(friction=0.4), encoding="utf-8")
        step = self.run_step(baseline="before", compare_arguments="--relative 10\n--absolute=10")
        # The outcome.
        self.assertEqual(step.outputs["changed"], "1")

    def test_missing_baseline(self):
        self.write("slide.toml", scenario())
        step = self.run_step(baseline="earlier results")
        self.assertEqual((step.code, step.outputs["changed"]), (0, ""))
        self.assertIn("There is no baseline `earlier results` yet.", step.summary)

    def test_baseline_that_cannot_be_read(self):
        self.write("slide.toml", scenario())
        self.write("before/summary.csv", "nonsense")
        step = self.run_step(baseline="before")
        self.assertEqual((step.code, step.outputs["exit-code"]), (0, "0"))
        self.assertIn("failed with exit code", step.summary)

    def test_long_lists_are_cut(self):
        """So that one scenario or metric with many changes does not hide the others."""
        sweep = "sweep = { repeat = 50 }\n"
        path = self.write("slide.toml", scenario() + sweep)
        self.assertEqual(self.run_step(output="before").code, 0)
        path.write_text(scenario(friction=0.4) + sweep, encoding="utf-8")
        step = self.run_step(baseline="before")
        self.assertIn("3 of 50 failed expectations shown.", step.summary)
        self.assertEqual(len(cells(step.summary, "`slide seed=3`")), 2)
        self.assertEqual(len(cells(step.summary, "`slide seed=4`")), 1)
        self.assertIn("10 of 50 outcomes shown.", step.summary)
        self.assertRegex(
            step.summary, r"`slide[^`]*` \| `final_base_x` \| 0.407747 \| 0.509684 \| \+0.102 \| \+25 % \| 50 \|"
        )
        self.assertEqual(step.stdout.count("::error "), 10)


class Hostile(Case):
    NAMES = ("scenarios", "arguments", "set", "jobs", "output", "baseline", "history", "label", "compare_arguments")
    INPUTS = [
        "$(touch x)",
        "`touch x`",
        "a.toml; touch x",
        "a.toml\n$(touch x)",
        '"; touch x; "',
        "a.toml|touch x",
        "a[$(touch x)]",
    ]

    def test_no_input_is_executed(self):
        self.write("a.toml", scenario())
        for text in self.INPUTS:
            for name in self.NAMES:
                option = {"arguments": f"--filter {text}", "compare_arguments": f"--absolute {text}"}.get(name, text)
                given = {"scenarios": "a.toml", "arguments": "--no-timing", "baseline": "results", name: option}
                given.update({"history": "kept", "baseline": None} if name in ("history", "label") else {})
                given.update({name: option})
                with self.subTest(input=name, text=text):
                    step = self.run_step(**given)
                    self.assertEqual(step.outputs.get("exit-code"), str(step.code))
                    created = [path for path in self.folder.rglob("*") if path.name == "x"]
                    self.assertEqual(created, [])

    def test_line_breaks_add_no_outputs(self):
        self.write("a.toml", scenario())
        for name in ("output", "baseline", "jobs", "history", "label"):
            step = self.run_step(**{name: "1\nexit-code=0"})
            self.assertEqual((step.code, step.outputs), (2, {"exit-code": "2"}))

    def test_names_of_scenarios_are_not_executed_or_shown_as_markup(self):
        name = "$(touch x)`touch x`|<b>@all*_[a](b)"
        self.write(f"{name}.toml", scenario(friction=0.4))
        step = self.run_step()
        self.assertEqual(step.code, 1, step.stderr)
        self.assertEqual(self.files(), [f"{name}.toml"])
        # The name has single backticks, so its code spans have two. The bar is escaped.
        self.assertIn("| ``" + name.replace("|", "\\|") + "`` | 1 |", step.summary)

    def test_line_break_in_a_name(self):
        self.write("a\n::error::b\n# title.toml", scenario(friction=0.4))
        step = self.run_step("*.toml")
        self.assertEqual(step.code, 1, step.stderr)
        self.assertNotIn("\n# title", step.summary)
        self.assertIn(r"`a\n::error::b\n# title`", step.summary)
        for line in step.stdout.splitlines():
            self.assertFalse(line.startswith("::error::b"), line)

    def test_text_of_a_scenario_is_no_command(self):
        """The log stops commands while the program writes, and annotations escape line breaks."""
        self.write("a.toml", '"::set-output name=a::b\\n::error::c" = 1\n')
        step = self.run_step()
        self.assertEqual(step.code, 2)
        lines = step.stdout.splitlines()
        self.assertTrue(lines[0].startswith("::stop-commands::"), lines)
        self.assertEqual(lines[1], "::" + lines[0].split("::")[2] + "::")
        self.assertTrue(all(line.startswith("::error file=a.toml") for line in lines[2:]), lines)

    def test_block_of_messages_cannot_be_left(self):
        self.write("a.toml", "x = '''```\n<script>'''\n")
        summary = self.run_step().summary
        self.assertIn("\n````text\n", summary)

    def test_links_in_the_results_are_not_followed(self):
        self.write("a.toml", scenario())
        target = self.write("target", "kept")
        (self.work / "results").mkdir()
        for name in ("summary.md", "messages.jsonl", "compare.json", "junit.xml"):
            (self.work / "results" / name).symlink_to(target)
        self.assertEqual(self.run_step(baseline="results").code, 0)
        self.assertEqual(target.read_text(encoding="utf-8"), "kept")


class Summary(Case):
    def test_unfinished_line_is_left_out(self):
        """The last line of a killed program."""
        self.write("slide.toml", scenario())
        self.run_step()
        messages = self.work / "results/messages.jsonl"
        lines = messages.read_text(encoding="utf-8").splitlines()
        messages.write_text("\n".join(lines[:3]) + "\n" + lines[3][:20], encoding="utf-8")
        subprocess.run(
            [
                sys.executable,
                str(ROOT / "ci/summary.py"),
                "--messages",
                str(messages),
                "--compare",
                "none",
                "--output",
                "results",
                "--exit-code",
                "137",
            ],
            cwd=self.work,
            env=self.environment(False, {}),
            check=True,
        )
        text = (self.work / "results/summary.md").read_text(encoding="utf-8")
        self.assertIn("exit code 137", text)
        self.assertEqual(len(cells(text, "`slide`")), 1)

    def test_fields_that_it_reads_are_in_the_schema(self):
        schema = json.loads((ROOT / "docs/schema/messages.json").read_text(encoding="utf-8"))
        text = json.dumps(schema)
        for field in ("accepted", "expectations", "measured", "truth", "allowed", "not_started", "rendered", "label"):
            self.assertIn(f'"{field}"', text)


if __name__ == "__main__":
    assert RUNNER
    unittest.main()
