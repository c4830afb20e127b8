#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""tenter fit on captures of a deforming sheet, against tenterd with the real worker: progress, report, residuals of
vertices, and a worker killed in the middle."""
import csv
import io
import json
import os
import pathlib
import signal
import subprocess

import cli_support
from cli_support import PROGRAMS, CommandTest, Daemon

ROLES = ("stretch_u", "stretch_v", "shear", "bend_u", "bend_v")


class Sheets(CommandTest):
    workers = 1

    def captures(self, nodes, frames, roles=ROLES):
        subprocess.run([PROGRAMS.sheets, self.work, str(nodes), str(frames), *roles], check=True)
        return [f"{role}.h5" for role in roles]

    def fit_arguments(self, files, *more):
        roles = [argument for file in files for argument in ("--role", f"{file}={file[:-3]}")]
        return ("fit", *files, *roles, *more)

    def test_a_person_fits_reads_and_asks(self):
        files = self.captures(7, 4)
        done = self.run_command(*self.fit_arguments(files, "--model", "cloth_stvk", "--resolution", "7", "--held-out",
                                                    "shear.h5", "--starts", "2", "--seed", "5", "--report", "fit.html", "--save-model", "fitted.json",
                                                    "-o", "result.json"))
        for words in ("The fit misses", "[HELD OUT]", "[SYNTHETIC]", "in the best basin", "stretch u", "coupled", "model written to"):
            self.assertIn(words, done.stdout)
        self.assertRegex(done.stderr, "running  (stretch|bend|coupled)")
        result = json.loads((self.work / "result.json").read_text())
        values = {p["name"]: p["value"] for p in result["parameters"]}
        self.assertAlmostEqual(values["weft.k"], 45.0, delta=2.0)
        self.assertAlmostEqual(values["warp.k"], 80.0, delta=4.0)
        self.assertEqual([result["starts"][key] for key in ("count", "seed")], [2, 5])
        self.assertEqual([c["held_out"] for c in result["captures"]], [False, False, True, False, False])
        page = (self.work / "fit.html").read_text()
        for part in ('id="curves"', 'id="sheets"', 'id="starts"', 'svg class="mesh"', ">HELD OUT</span>"):
            self.assertIn(part, page)
        self.assertEqual(json.loads((self.work / "fitted.json").read_text())["schema"], "tenter.model")
        self.assertIn("The fit misses", self.run_command("report", "last").stdout)
        digest = self.json("report", "last")
        self.assertIn("stages", digest)
        self.assertNotIn("meshes", digest)

        text = self.run_command("residuals", "last", "--vertices", "--capture", digest["captures"][0]["id"][:8],
                                "--frames", "2:3", "--vertex", "15:17", "--format", "csv").stdout
        rows = list(csv.DictReader(io.StringIO(text)))
        self.assertEqual([(r["frame"], r["vertex"]) for r in rows],
                         [(f, v) for f in "23" for v in ("15", "16", "17")])
        for row in rows:
            self.assertLess(float(row["residual_m"]), 8 * float(row["sigma_m"]))
        forces = self.json("residuals", "last", "--channel", "moved")["tables"]
        self.assertEqual({len(t["rows"]) for t in forces}, {4})
        self.assertGreater(forces[0]["rows"][-1]["displacement_m"], 0.002)
        # the same again is answered from the store
        self.assertTrue(self.json(*self.fit_arguments(files, "--model", "cloth_stvk", "--resolution", "7",
                                                      "--held-out", "shear.h5", "--starts", "2", "--seed", "5",
                                                      "--detach"))["from_store"])

    def test_the_error_of_the_grid_is_taken_off(self):
        files = self.captures(13, 2, ("shear", "bend_u", "bend_v"))
        done = self.run_command(*self.fit_arguments(files, "--model", "cloth_stvk", "--resolution", "7", "--points", "60",
                                                    "--without-grid-error", "--hold-unseen", "5e-5", "--report", "fit.html",
                                                    "-o", "result.json"))
        self.assertIn("taken off: up to", done.stdout)
        result = json.loads((self.work / "result.json").read_text())
        self.assertEqual([result["options"][key] for key in ("without_grid_error", "hold_unseen")], [True, 5e-5])
        self.assertEqual(len(result["grid_error"]["captures"]), 3)
        self.assertGreater(result["grid_error"]["captures"][0]["force"]["rms"], 1e-4)
        held = {p["name"]: p["held"] for p in result["parameters"]}
        self.assertTrue(held["bend_diagonal.k"])
        self.assertFalse(held["shear.k"])
        page = (self.work / "fit.html").read_text()
        for words in ('id="grid-error"', "held: the captures do not tell it"):
            self.assertIn(words, page)

    def test_a_diagnosis_finds_nothing_where_nothing_is_wrong(self):
        files = self.captures(7, 6, ("stretch_u", "stretch_v", "shear"))
        done = self.run_command("diagnose", *files, "--model", "cloth_stvk", "--resolution", "7", "--grid", "equal", "--hold-out",
                                "shear.h5", "--report", "why.html", "-o", "why.json")
        result = json.loads((self.work / "why.json").read_text())
        self.assertEqual(result["verdicts"][0]["verdict"], "NOTHING_FOUND", result["verdicts"])
        self.assertIn("othing found", done.stdout)
        self.assertEqual([c["held_out"] for c in result["captures"]], [False, False, True])
        page = (self.work / "why.html").read_text()
        for part in ('id="sheets"', 'id="screen"', 'svg class="mesh"'):
            self.assertIn(part, page)

    def test_mistakes_are_told_in_one_sentence(self):
        files = self.captures(5, 2, ("stretch_u", "stretch_v"))
        for more, code, words in ((("--role", "x.h5=shear"), 2, "--role x.h5: is none of the captures given"),
                                  (("--set", "resolutoin=9"), 7, "options.resolutoin: no such option"),
                                  (("--leave-out", "runs"), 7, "options.leave_out: no such option")):
            self.assertIn(words, self.json(*self.fit_arguments(files, *more), code=code)["error"]["message"])
        # told before a worker starts
        for more, words in ((("--samples", "2"), "options.samples: needs a capture that is held out"),
                            (("--without-grid-error", "--grid", "equal"), "do not go together: a table's edge"),
                            (("--limits",), "options.limits: the model has 0 energy limits"),
                            (("--convex", "every_step", "--profiles"), "and options.profiles do not go together")):
            self.assertIn(words, self.json(*self.fit_arguments(files, *more), code=2)["error"]["message"])
        error = self.json("fit", *files, code=7)["error"]["message"]
        self.assertIn("options.roles: capture", error)
        self.assertIn("simulate does not take them", self.json("simulate", *files, code=7)["error"]["message"])

    def workers_of(self, daemon):
        pids = []
        for task in pathlib.Path(f"/proc/{daemon.process.pid}/task").iterdir():
            pids += (task / "children").read_text().split()
        return [int(pid) for pid in pids]

    def stages_kept(self, daemon):
        for file in (daemon.folder / "store" / "checkpoints").glob("*/stages.json"):
            try:
                return len(json.loads(file.read_text())["fit"]["stages"])
            except (OSError, ValueError):
                return 0
        return 0

    def test_a_killed_worker_goes_on_to_the_same_bytes(self):
        files = self.captures(9, 4, ROLES[:4])
        arguments = self.fit_arguments(files, "--model", "cloth_stvk_spline", "--resolution", "9",
                                       "--max-control-points", "3")
        self.run_command(*arguments, "-o", "whole.json")

        other = Daemon(1)
        self.addCleanup(other.close)
        environment = dict(self.environment("ada"), TENTER_DOMAIN=str(other.domain))
        command = subprocess.Popen([PROGRAMS.tenter, *arguments, "-o", "resumed.json"], cwd=self.work, env=environment,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.wait_for(lambda: self.stages_kept(other) >= 3, "some stages are done", 60)
        for pid in self.workers_of(other):
            os.kill(pid, signal.SIGKILL)
        _, errors = command.communicate(timeout=120)
        self.assertEqual(command.returncode, 0, errors)
        self.assertIn("attempt 2", errors)
        # what it says after that is of later stages
        self.assertNotIn("attempt 2  stretch_", errors)
        self.assertEqual((self.work / "resumed.json").read_bytes(), (self.work / "whole.json").read_bytes())
        self.wait_for(lambda: self.stages_kept(other) == 0, "its checkpoint is gone")


if __name__ == "__main__":
    cli_support.main()
