#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The main job over DDS with the real worker: captures of a real knit and a twin in, verdicts, report, residuals out."""
import csv
import io
import json
import pathlib
import shutil

import cli_support
from cli_support import PROGRAMS, CommandTest

VERDICTS = {"NAMED", "AMBIGUOUS", "SENSOR", "NOT_EXCITED", "UNEXPLAINED", "NUMERICAL", "NOTHING_FOUND"}


class Diagnose(CommandTest):
    def test_a_twin_with_friction_from_file_to_report(self):
        twin = pathlib.Path(PROGRAMS.data) / "twin" / "friction_loops.h5"
        found = self.json("diagnose", twin, "--report", "report.html", "--output", "result.json",
                          "--save-model", "extended.json", timeout=300)
        for key in ("job_id", "noise_floor", "error_before", "error_after", "held_out_before", "held_out_after",
                    "unexplained_share", "captures", "verdicts"):
            self.assertIn(key, found)
        self.assertGreater(len(found["verdicts"]), 0)
        for verdict in found["verdicts"]:
            self.assertIn(verdict["verdict"], VERDICTS)
            for key in ("effect", "size", "interval", "p_value", "alternatives", "next_protocol"):
                self.assertIn(key, verdict)
        meant = {effect for v in found["verdicts"] if v["verdict"] in ("NAMED", "AMBIGUOUS")
                 for effect in [v["effect"], *v["alternatives"]]}
        self.assertTrue(meant & {"internal_friction", "strain_dependent_friction"}, found["verdicts"])
        self.assertLess(found["error_after"], 0.5 * found["error_before"])
        self.assertTrue(all(c["synthetic"] for c in found["captures"]))

        page = (self.work / "report.html").read_text()
        self.assertIn("SYNTHETIC", page)
        self.assertIn('<svg class="plot"', page)
        if PROGRAMS.artefacts:
            pathlib.Path(PROGRAMS.artefacts).mkdir(parents=True, exist_ok=True)
            shutil.copy(self.work / "report.html", pathlib.Path(PROGRAMS.artefacts) / "twin.html")

        job = found["job_id"]
        self.run_command("report", job, "-o", "again.html")
        self.assertEqual(page, (self.work / "again.html").read_text())
        self.assertIn(found["verdicts"][0]["verdict"].replace("_", " "), self.run_command("report", "last").stdout)
        self.check_residuals(job, found["captures"][0]["id"])

        # the same work again: the same bytes, from the store
        again = self.json("diagnose", twin, "--output", "second.json", timeout=60)
        self.assertNotEqual(again["job_id"], job)
        self.assertEqual((self.work / "result.json").read_bytes(), (self.work / "second.json").read_bytes())

        # the extended model is a model like any other
        self.run_command("model", "validate", "extended.json")
        simulated = self.json("simulate", twin, "--model", "extended.json", timeout=120)
        self.assertAlmostEqual(simulated["error_after"], found["error_after"], delta=0.02)

    def check_residuals(self, job, capture):
        tables = self.json("residuals", job)["tables"]
        rows = sum(len(t["rows"]) for t in tables)
        self.assertGreater(rows, 100)
        text = self.run_command("residuals", job, "--format", "csv").stdout
        lines = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual(len(lines), rows)
        first = next(r for r in lines if r["measured"] and r["extended"])
        left = float(first["measured"]) - float(first["extended"])
        self.assertAlmostEqual(left, float(first["residual_extended"]), delta=1e-6 * (1.0 + abs(left)))
        some = self.json("residuals", job, "--capture", capture[:8], "--channel", tables[0]["channel"], "--block", "0")
        self.assertEqual({r["block"] for t in some["tables"] for r in t["rows"]}, {0})
        frames = sorted(r["frame"] for t in some["tables"] for r in t["rows"])
        few = self.json("residuals", job, "--frames", f"{frames[1]}:{frames[3]}")
        self.assertLessEqual({r["frame"] for t in few["tables"] for r in t["rows"]}, set(range(frames[1], frames[3] + 1)))
        self.run_command("residuals", job, "--channel", "nothing", code=3)
        self.assertIn("measured", self.run_command("residuals", job, "--block", "0").stdout)

    def test_going_on_with_new_captures(self):
        twin = pathlib.Path(PROGRAMS.data) / "twin" / "friction_loops.h5"
        first = self.json("diagnose", twin, "--max-effects", "3", timeout=300)
        again = self.json("diagnose", twin, "--continue", first["job_id"], "--set", "rig_strain=0.05", timeout=300)
        self.assertEqual([c["id"] for c in again["captures"]], [c["id"] for c in first["captures"]])
        self.assertEqual(again["continues"]["job"], first["job_id"])
        said = [v for v in first["verdicts"] if v["verdict"] != "NOT_EXCITED"]
        self.assertEqual([(s["verdict"], s.get("effect")) for s in again["continues"]["said"]],
                         [(v["verdict"], v["effect"]) for v in said])
        spec = self.json("job", "show", again["job_id"])["spec"]
        self.assertEqual((spec["options"]["max_effects"], spec["options"]["rig_strain"]), (3, 0.05))
        self.assertIn("goes on from job " + first["job_id"], self.run_command("report", "last").stdout)
        # a proposed pull has its numbers, and keeps the rig's limits
        for verdict in again["verdicts"]:
            design = (verdict["next_protocol"] or {}).get("design")
            if verdict["verdict"] == "AMBIGUOUS" and design:
                self.assertGreater(design["expected_separation"], 0.5)
                self.assertLessEqual(max(abs(s.get("strain", 0)) for s in design["steps"]), 0.05 + 1e-9)
                self.assertEqual(len(design["steps"]), len(verdict["next_protocol"]["phases"]))

        fitted = self.json("fit", twin, "--model", "stvk_diagonal", timeout=120)
        done = self.run_command("diagnose", twin, "--continue", fitted["job_id"], code=2)
        self.assertIn("only a diagnosis can be continued", done.stderr)
        done = self.run_command("diagnose", twin, "--set", "rig_strain=-1", code=7)
        self.assertIn("options.rig_strain", done.stderr)

    def test_a_real_knit(self):
        knit = self.capture("acrylic_rib_x")
        done = self.run_command("diagnose", knit, "--report", "knit.html", "--output", "knit.json", timeout=300)
        found = json.loads((self.work / "knit.json").read_text())
        self.assertFalse(found["captures"][0]["synthetic"])
        meant = {v["effect"] for v in found["verdicts"] if v["verdict"] in ("NAMED", "AMBIGUOUS", "SENSOR")}
        self.assertIn("nonlinear_stiffness", meant)
        self.assertLess(found["held_out_after"], found["held_out_before"])
        self.assertIn("nonlinear stiffness", done.stdout)
        if PROGRAMS.artefacts:
            pathlib.Path(PROGRAMS.artefacts).mkdir(parents=True, exist_ok=True)
            shutil.copy(self.work / "knit.html", pathlib.Path(PROGRAMS.artefacts) / "knit.html")

    def test_fit_keeps_a_model_with_intervals(self):
        knit = self.capture("cotton_stockinette_x")
        fitted = self.json("fit", knit, "--model", "stvk_diagonal", "--save-model", "fitted.json", timeout=120)
        self.assertGreater(fitted["error_after"], 0.0)
        model = json.loads((self.work / "fitted.json").read_text())
        self.assertIn("std_error", json.dumps(model))
        self.run_command("fit", knit, "--model", "fitted.json", timeout=120)


if __name__ == "__main__":
    cli_support.main()
