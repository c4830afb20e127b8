#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""tenter fit --protocol against tenterd with the real worker: hanging weights, spirals, and loops that are no friction."""
import csv
import io
import json
import math
import subprocess

import cli_support
from cli_support import PROGRAMS, CommandTest


class Friction(CommandTest):
    workers = 1

    def import_table(self, name):
        if not (self.work / f"{name}.csv").exists():
            subprocess.run([PROGRAMS.friction_tables, self.work], check=True)
        self.run_command("capture", "import", f"{name}.csv", "--describe", f"{name}.json", "-o", f"{name}.h5")

    def numbers(self, digest):
        return {n["name"]: n for n in digest["friction_test"]["parts"][0]["numbers"]}

    def test_hanging_weights(self):
        self.import_table("weights")
        done = self.run_command("fit", "weights.h5", "--protocol", "hanging-weights", "--report", "friction.html",
                                "--save-model", "fitted.json")
        self.assertIn("Warp: 5 of 5 numbers are told; friction a = ", done.stdout)
        self.assertRegex(done.stderr, "running  fit")
        page = (self.work / "friction.html").read_text()
        for part in ('id="friction"', "Length against weight", "SYNTHETIC"):
            self.assertIn(part, page)
        digest = self.json("report", "last")
        numbers = self.numbers(digest)
        for name, truth in (("k1", 26.62), ("a", 2.10), ("tau", 0.031)):
            self.assertLess(abs(numbers[name]["value"] - truth), numbers[name]["interval"][1] - numbers[name]["interval"][0])
        text = self.run_command("residuals", "last", "--channel", "hanging_stretch", "--format", "csv").stdout
        rows = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual(len(rows), 3 * (1 + sum(2 * n for n in range(1, 7))))
        self.assertLess(max(abs(float(r["residual_extended"])) / float(r["sigma"]) for r in rows), 6.0)
        self.assertEqual(json.loads((self.work / "fitted.json").read_text())["schema"], "tenter.model")
        # what does not go with it is told
        error = self.json("fit", "weights.h5", "--protocol", "spiral", code=7)["error"]["message"]
        self.assertIn("its kind is homogeneous_strain", error)
        self.run_command("fit", "weights.h5", "--protocol", "weights", code=2)

    def test_spirals(self):
        self.import_table("strips")
        self.assertIn("strip_profiles", self.run_command("capture", "show", "strips.h5").stdout)
        done = self.run_command("fit", "strips.h5", "--protocol", "spiral", "--report", "bending.html")
        self.assertIn("Warp, positive sense", done.stdout)
        self.assertRegex(done.stderr, "running  (profiles|fit)")
        self.assertIn("Curvature along the strips", (self.work / "bending.html").read_text())
        digest = self.json("report", "last")
        a = self.numbers(digest)["a"]
        self.assertTrue(a["told"])
        self.assertAlmostEqual(a["value"] / 12.84e-4, 1.0, delta=0.05)
        tables = self.json("residuals", "last")["tables"]
        self.assertEqual([t["channel"] for t in tables], ["bend_v_positive", "bend_v_positive_torque"])
        alone = self.json("fit", "strips.h5", "--protocol", "cantilever")
        self.assertGreater(self.numbers(alone)["k1"]["value"], 1.3 * 62.19e-7)
        self.assertIn("strips are fitted with options.protocol",
                      self.json("diagnose", "strips.h5", code=7)["error"]["message"])

    def test_loops_that_depend_on_the_rate_are_refused(self):
        lines = ["run,t_s,stretch,load"]
        for run, step in ((1, 0.1), (2, 1.0)):
            viscous, before = 0.0, 1.0
            for i in range(81):
                stretch = 1.0 + 0.1 * (1.0 - abs(i / 40 - 1.0))
                decay = math.exp(-step / 10.0)
                viscous = viscous * decay + 400.0 * (stretch - before) * 10.0 / step * (1.0 - decay)
                before = stretch
                lines.append(f"{run},{i * step},{stretch},{100.0 * (stretch - 1.0) + viscous}")
        (self.work / "loops.csv").write_text("\n".join(lines) + "\n")
        (self.work / "loops.json").write_text(json.dumps({
            "kind": "homogeneous_strain", "title": "Two rates",
            "columns": {"run": {"is": "run"}, "t_s": {"is": "time", "unit": "s"},
                        "stretch": {"quantity": "stretch", "unit": "1"},
                        "load": {"quantity": "membrane_stress", "unit": "N/m"}},
            "specimen": {"name": "strip", "material": "polymer"},
            "protocol": {"name": "loops", "history": "virgin_each_run"}, "provenance": {"source": "made up", "synthetic": True},
            "kinematics": {"x": {"role": "prescribed", "channel": "stretch"}, "y": {"role": "free"}},
            "stresses": {"x": "load"}}))
        self.import_table("loops")
        error = self.json("fit", "loops.h5", "--protocol", "loops", code=7)["error"]["message"]
        for words in ("refused as friction", "depends on the rate of strain", "times the work"):
            self.assertIn(words, error)


if __name__ == "__main__":
    cli_support.main()
