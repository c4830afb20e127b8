#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""tenter against tenterd, over DDS: captures, jobs, errors, signals. The worker's science is faked, nothing else."""
import json
import os
import signal
import subprocess
import time

import cli_support
from cli_support import PROGRAMS, CommandTest, on_terminal


def fake(**options):
    return "fake=" + json.dumps(options)


class Captures(CommandTest):
    def test_import_submit_list_show_export(self):
        file = self.capture()
        first = self.json("capture", "submit", file)["captures"][0]
        again = self.json("capture", "submit", file)["captures"][0]
        self.assertTrue(again["already_stored"])
        self.assertEqual(first["id"], again["id"])
        listed = self.json("capture", "list")["captures"]
        self.assertIn(first["id"], [c["id"] for c in listed])
        self.assertIn(first["id"][:12], self.run_command("capture", "list").stdout)

        # by hash from the server, the same as from the file
        shown = self.json("capture", "show", first["id"][:8])
        self.assertEqual(shown, self.json("capture", "show", file))
        self.run_command("capture", "export", first["id"][:8], "-o", "back.csv")
        self.run_command("capture", "import", "back.csv", "--describe", "back.json", "-o", "back.h5")
        self.assertEqual((self.work / "back.h5").read_bytes(), file.read_bytes())
        self.run_command("capture", "export", first["id"][:8], "-o", "back.csv", code=4)

    def test_a_sheet_from_its_tables_to_the_server_and_back(self):
        tracked = ["frame,point,x_mm,y_mm,z_mm"]
        for frame in range(3):
            for point in range(9):
                u, v = 50 * (point % 3), 50 * (point // 3)
                tracked.append(f"{frame},{point},{u * (1 + 0.01 * frame)},{v},{0.1 * frame}")
        (self.work / "tracked.csv").write_text("\n".join(tracked) + "\n")
        (self.work / "mesh.obj").write_text(
            "".join(f"v {50 * (k % 3)} {50 * (k // 3)} 0\n" for k in range(9)) +
            "f 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\nf 5 6 9 8\n")
        (self.work / "forces.csv").write_text("frame;pull_mN\n0;0\n1;1250,5\n2;2501\n")
        description = {
            "kind": "deforming_sheet", "title": "a square", "gravity_m_s2": [0, 0, -9.81],
            "specimen": {"name": "S", "material": "cloth", "area_density": {"value": 150, "unit": "g/m2"}},
            "protocol": {"name": "pull", "history": "continues", "branch": "load"},
            "provenance": {"source": "a test", "synthetic": True},
            "mesh": {"file": "mesh.obj", "unit": "mm"},
            "positions": {"file": "tracked.csv", "unit": "mm", "sigma": 0.075, "columns": {
                "frame": "frame", "vertex": "point", "x": "x_mm", "y": "y_mm", "z": "z_mm"}},
            "clips": [{"id": "right", "role": "prescribed", "region": {"unit": "mm", "box": [[100, 0], [100, 100]]},
                       "pose": {"unit": "mm", "position": [0, 0, 0]}}],
            "cords": [{"id": "pull", "clip": "right", "direction": [1, 0, 0], "tension": {
                "file": "forces.csv", "separator": ";", "decimal": ",", "unit": "mN", "sigma": 3,
                "columns": {"frame": "frame", "tension": "pull_mN"}}}]}
        (self.work / "sheet.json").write_text(json.dumps(description))
        made = self.json("capture", "import", "sheet.json")
        self.assertEqual((made["file"], made["sheet"]["vertices"], made["sheet"]["triangles"]), ("sheet.h5", 9, 8))
        self.assertTrue(self.json("capture", "validate", "sheet.h5")["captures"][0]["valid"])
        sent = self.json("capture", "submit", "sheet.h5")["captures"][0]
        self.assertEqual(sent["id"], made["id"])
        self.assertEqual(sent["summary"]["summary"]["sheet"]["cords"], 1)
        self.assertIn("deforming_sheet", self.run_command("capture", "list").stdout)
        shown = self.json("capture", "show", made["id"][:8])
        self.assertAlmostEqual(shown["sheet"]["cords"][0]["highest_N"], 2.501)
        self.assertIn("cord        pull at right: 0 .. 2.501 N", self.run_command("capture", "show", "sheet.h5").stdout)
        files = self.json("capture", "export", made["id"][:8], "-o", "back.json")["files"]
        self.assertIn("back.obj", files)
        self.run_command("capture", "import", "back.json", "-o", "again.h5")
        self.assertEqual((self.work / "again.h5").read_bytes(), (self.work / "sheet.h5").read_bytes())
        # what is wrong is said in one line, and nothing is left
        description["positions"]["columns"]["x"] = "x_cm"
        (self.work / "bad.json").write_text(json.dumps(description))
        done = self.run_command("capture", "import", "bad.json", code=2)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1)
        self.assertIn("tracked.csv: has no column \"x_cm\"", done.stderr)
        self.assertFalse((self.work / "bad.h5").exists())
        self.run_command("capture", "import", "tracked.csv", code=2)

    def test_bad_captures_are_refused_with_a_reason(self):
        torn = self.work / "torn.h5"
        torn.write_bytes(self.capture().read_bytes()[:5000])
        for arguments in (("capture", "validate", torn), ("capture", "submit", torn), ("diagnose", torn)):
            error = self.json(*arguments, code=2)["error"]
            self.assertEqual(error["kind"], "bad_input")
            self.assertIn("torn.h5", error["message"])
        self.assertNotIn("torn", json.dumps(self.json("capture", "list")))
        bad = self.work / "bad.json"
        bad.write_text("{}")
        done = self.run_command("capture", "import", torn, "--describe", bad, "-o", "x.h5", code=2)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1)
        self.assertFalse((self.work / "x.h5").exists())
        self.run_command("capture", "show", "0123456789", code=3)
        self.run_command("capture", "submit", "nowhere.h5", code=2)


class Jobs(CommandTest):
    def submitted(self, *more, user="ada", **options):
        file = self.capture()
        return self.json("fit", file, "--detach", "--set", fake(**options), *more, user=user)["job_id"]

    def test_status_names_server_store_jobs_and_clients(self):
        status = self.json("server", "status")
        self.assertEqual(status["server"]["domain"], self.daemon.domain)
        text = self.run_command("server", "status").stdout
        for word in ("tenterd", "store", "jobs", "workers", "ada"):
            self.assertIn(word, text)

    def test_the_life_of_a_job(self):
        job = self.submitted("--priority", "7", "--model", "springs", sleep_ms=300, tag="life")
        self.run_command("job", "watch", job)
        shown = self.json("job", "show", job)
        self.assertEqual((shown["state"], shown["priority"], shown["user"]), ("succeeded", 7, "ada"))
        self.assertIn("springs", self.run_command("job", "show", job).stdout)
        self.assertIn("fake worker runs", self.run_command("job", "log", job).stdout)
        self.assertIn(job, [j["id"] for j in self.json("job", "list", "--of", "me")["jobs"]])
        self.assertEqual(self.json("job", "list", "--of", "nobody-else")["jobs"], [])
        # the same again is answered from the store
        again = self.json("fit", self.capture(), "--detach", "--model", "springs", "--set",
                          fake(sleep_ms=300, tag="life"))
        self.assertTrue(again["from_store"])

    def test_the_same_request_id_is_the_same_job(self):
        first = self.submitted("--request-id", "mine", sleep_ms=10)
        again = self.submitted("--request-id", "mine", sleep_ms=10)
        self.assertEqual(first, again)

    def test_a_specification_of_ones_own(self):
        capture = self.json("capture", "submit", self.capture())["captures"][0]["id"]
        model = json.loads(self.run_command("model", "show", "springs").stdout)
        spec = {"schema": "tenter.job", "version": 1, "kind": "fit", "captures": [capture], "model": model}
        job = self.json("job", "submit", "-", stdin=json.dumps(spec))["job_id"]
        self.run_command("job", "watch", job)
        del spec["captures"]
        error = self.json("job", "submit", "-", stdin=json.dumps(spec), code=2)["error"]
        self.assertIn("captures", error["message"])
        spec["captures"] = ["0" * 64]
        self.json("job", "submit", "-", stdin=json.dumps(spec), code=3)

    def test_failed_jobs_exit_with_7_and_say_why(self):
        done = self.run_command("fit", self.capture(), "--set", fake(fail="the yarn broke"), code=7)
        self.assertIn("the yarn broke", done.stderr)
        error = self.json("fit", self.capture(), "--set", fake(fail="it broke again"), code=7)["error"]
        self.assertEqual(error["kind"], "job_failed")
        self.run_command("job", "retry", error["job_id"])
        self.run_command("job", "watch", error["job_id"], code=7)

    def test_cancelled_jobs_exit_with_8(self):
        job = self.submitted(sleep_ms=60000)
        watch = self.start("job", "watch", job)
        self.wait_for(lambda: self.json("job", "show", job)["state"] == "running", "the job runs")
        self.assertEqual(self.json("job", "cancel", job)["state"], "cancelled")
        _, errors = watch.communicate(timeout=20)
        self.assertEqual(watch.returncode, 8, errors)
        self.assertIn("cancelled", errors)

    def test_jobs_wait_for_others(self):
        first = self.submitted(sleep_ms=400, tag="first")
        second = self.submitted("--after", first, tag="second")
        self.run_command("job", "watch", second)
        self.assertEqual(self.json("job", "show", first)["state"], "succeeded")

    def test_control_c_stops_watching_and_the_job_goes_on(self):
        command = self.start("fit", self.capture(), "--set", fake(sleep_ms=1500, tag="detach"))
        self.wait_for(lambda: [j for j in self.json("job", "list", "--state", "running")["jobs"]], "the job runs")
        command.send_signal(signal.SIGINT)
        _, errors = command.communicate(timeout=10)
        self.assertEqual(command.returncode, 8, errors)
        self.assertIn("goes on", errors)
        job = errors.split("tenter job watch ")[1].split(",")[0]
        self.run_command("job", "watch", job)

    def test_progress_is_redrawn_on_a_terminal_and_lines_elsewhere(self):
        file = self.capture()
        command = [PROGRAMS.tenter, "fit", str(file), "--set", fake(sleep_ms=1500, tag="terminal")]
        _, text = on_terminal(command, self.environment("ada"), self.work)
        self.assertGreater(text.count("\r\x1b[K"), 5)
        self.assertIn("about", text)
        self.assertIn("left", text)
        lines = self.run_command("fit", file, "--detach", "--set", fake(sleep_ms=700, tag="lines"))
        job = lines.stdout.split()[1]
        errors = self.run_command("job", "watch", job).stderr
        self.assertNotIn("\x1b", errors)
        self.assertIn("running", errors)
        self.assertEqual(self.run_command("-q", "job", "watch", job).stderr, "")

    def test_two_users_have_their_own_last_job(self):
        one = self.submitted(user="ada", tag="one")
        two = self.submitted(user="bob", tag="two")
        self.assertEqual(self.json("job", "show", "last", user="ada")["id"], one)
        self.assertEqual(self.json("job", "show", "last", user="bob")["id"], two)
        slow = self.submitted(user="ada", sleep_ms=30000, tag="slow")
        self.assertEqual(self.json("job", "cancel", slow, user="bob", code=4)["error"]["kind"], "refused")
        self.run_command("job", "cancel", slow, user="ada")

    def test_what_is_not_there_exits_with_3(self):
        for arguments in (("job", "show", "999999"), ("job", "watch", "999999"), ("report", "999999"),
                          ("residuals", "999999"), ("job", "cancel", "999999")):
            self.assertEqual(self.json(*arguments, code=3)["error"]["kind"], "not_found", arguments)
        self.run_command("job", "show", "last", user="stranger", code=3)
        self.run_command("job", "show", "first", code=2)


class Restart(CommandTest):
    def test_watching_outlives_a_killed_daemon(self):
        job = self.json("fit", self.capture(), "--detach", "--set", fake(sleep_ms=3000))["job_id"]
        watch = self.start("job", "watch", job)
        self.wait_for(lambda: self.json("job", "show", job)["state"] == "running", "the job runs")
        self.daemon.kill()
        time.sleep(1.0)
        self.daemon.start()
        _, errors = watch.communicate(timeout=60)
        self.assertEqual(watch.returncode, 0, errors)
        self.assertEqual(self.json("job", "show", job)["state"], "succeeded")

    def test_without_a_server_the_exit_code_is_5(self):
        environment = dict(os.environ, TENTER_DOMAIN="232", TENTER_USER="ada")
        done = subprocess.run([PROGRAMS.tenter, "--timeout", "1", "--json", "server", "status"], env=environment,
                              capture_output=True, text=True, timeout=20)
        self.assertEqual(done.returncode, 5)
        self.assertEqual(json.loads(done.stdout)["error"]["kind"], "unavailable")


if __name__ == "__main__":
    cli_support.main()
