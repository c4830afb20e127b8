#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""tenter simulate --scene against tenterd with the real worker: submit, watch, fetch, look at what arrived."""
import hashlib
import json
import xml.etree.ElementTree as xml

import cli_support
from cli_support import CommandTest

MAGIC = b"\x89HDF\r\n\x1a\n"


class Scenes(CommandTest):
    workers = 1

    def scene(self, name="hanging_square", **changes):
        """A shipped scene with other members, as a file."""
        scene = json.loads(self.run_command("scene", "show", name).stdout)
        scene.update(changes)
        (self.work / "scene.json").write_text(json.dumps(scene))
        return "scene.json"

    def folder(self, name):
        return {file.name: file.read_bytes() for file in (self.work / name).iterdir()}

    def test_frames_arrive_and_paraview_is_told_where(self):
        result = self.json("simulate", "--scene", "hanging_square", "-o", "out")
        self.assertTrue(result["completed"])
        self.assertEqual(len(result["frames"]), 16)
        weight = 9.81 * (0.187 * 0.25 + 0.05)
        last = result["frames"][-1]["reactions"]
        self.assertAlmostEqual(last["left"]["force_N"][2] + last["right"]["force_N"][2], -weight, places=4)
        files = self.folder("out")
        self.assertEqual(sorted(files), ["frames.h5", "frames.xdmf", "result.json"])
        self.assertTrue(files["frames.h5"].startswith(MAGIC))
        shown = self.json("job", "show", result["job_id"])
        self.assertEqual(shown["frames_sha256"], hashlib.sha256(files["frames.h5"]).hexdigest())
        self.assertEqual(shown["result_sha256"], hashlib.sha256(files["result.json"]).hexdigest())

        grids = xml.fromstring(files["frames.xdmf"]).findall("./Domain/Grid/Grid")
        self.assertEqual(len(grids), 16)
        for number, grid in enumerate(grids):
            self.assertEqual(float(grid.find("Time").get("Value")), number)
            self.assertEqual(grid.find("Topology").get("NumberOfElements"), "1152")
            place = grid.find("Geometry/DataItem")
            self.assertEqual(place.get("Dimensions"), "625 3")
            self.assertEqual(place.text, f"frames.h5:/entry/frames/{number:06d}/position")
            self.assertEqual([a.get("Name") for a in grid.findall("Attribute")], ["weft", "warp", "shear"])

    def test_the_same_job_twice_is_the_same_bytes_from_the_store(self):
        self.run_command("simulate", "--scene", "picture_frame", "-o", "one")
        detached = self.json("simulate", "--scene", "picture_frame", "--detach", user="bob")
        self.assertTrue(detached["from_store"])
        self.run_command("simulate", "--scene", "picture_frame", "-o", "two", user="bob")
        self.assertEqual(self.folder("one"), self.folder("two"))
        self.run_command("simulate", "--scene", "picture_frame", "--set", "shear.k=90", "-o", "three")
        self.assertNotEqual(self.folder("one")["frames.h5"], self.folder("three")["frames.h5"])

    def test_a_person_reads_reactions_and_energies(self):
        done = self.run_command("simulate", "--scene", "corner_pull")
        for word in ("11 of 11 frames", "F_z (N)", "bar", "warp", "with -o DIR"):
            self.assertIn(word, done.stdout)
        self.assertIn("succeeded", done.stderr)
        self.assertIn("is a simulated scene", self.run_command("report", "last", code=2).stderr)
        self.run_command("residuals", "last", code=3)
        listed = self.run_command("scene", "list").stdout
        for name in ("hanging_square", "picture_frame", "corner_pull", "table_edge"):
            self.assertIn(name, listed)

    def test_an_experiment_has_a_figure(self):
        there_and_back = [{"name": name, "frames": 6, "duration_s": 6, "motions": [{"clip": "top", "move_m": [0, by, 0]}]}
                          for name, by in (("there", 0.003), ("back", -0.003))]
        scene = json.loads(self.run_command("scene", "show", "stretch_loops_cotton").stdout)
        scene["experiment"]["measures"] = [{"id": "lost", "kind": "work", "clip": "top", "words": "work lost"}]
        scene["experiment"]["pictures"] = [{"title": "stretched", "at": "there", "eye": [0, 0, 1], "up": [0, 1, 0]}]
        scene["protocol"] = there_and_back
        scene["mesh"].update({"nodes_u": 3, "nodes_v": 3})
        (self.work / "loop.json").write_text(json.dumps(scene))
        done = self.run_command("simulate", "--scene", "loop.json", "--figure", "loop.svg", "--report", "loop.html")
        for words in ("with cotton: 13 of 13 frames", "0.5 mm/s, without friction", "work lost (mJ): "):
            self.assertIn(words, done.stdout)
        drawn = xml.parse(self.work / "loop.svg").getroot()
        self.assertEqual(drawn.tag, "{http://www.w3.org/2000/svg}svg")
        texts = ["".join(text.itertext()) for text in drawn.iter("{http://www.w3.org/2000/svg}text")]
        self.assertEqual(texts.count("2 mm/s"), 3)  # picture, table, key of the plot
        painted = "".join(path.get("d") for path in drawn.iter("{http://www.w3.org/2000/svg}path") if path.get("color"))
        self.assertEqual(painted.count("Z"), 4 * 8)
        self.assertIn("report written to loop.html", done.stdout)
        page = (self.work / "loop.html").read_text()
        for words in ("work lost (mJ)</th>", "<code>warp_friction.tau</code>", "0.5 mm/s, without friction</td>",
                      scene["description"][:20]):
            self.assertIn(words, page)
        again = self.run_command("report", "last", "-o", "again.html")
        self.assertIn("written to again.html", again.stdout)
        self.assertEqual((self.work / "again.html").read_text(), page)
        self.assertIn("no 'experiment'", self.json("simulate", "--scene", "picture_frame", "--figure", "no.svg",
                                                   code=2)["error"]["message"])

    def test_a_mesh_of_ones_own(self):
        nodes = [f"v {i % 6} {i // 6} 0" for i in range(36)]
        faces = [f"f {r * 6 + c + 1} {r * 6 + c + 2} {r * 6 + c + 8} {r * 6 + c + 7}"
                 for r in range(5) for c in range(5)]
        (self.work / "cloth.obj").write_text("\n".join(nodes + faces) + "\n")
        scene = self.scene(mesh={"kind": "file", "path": "cloth.obj", "metres_per_unit": 0.02},
                           start={"place": "vertical"}, protocol=[])
        result = self.json("simulate", "--scene", scene)
        self.assertEqual((result["nodes"], result["elements"]["triangle"]), (36, 50))
        total = sum(clip["force_N"][2] for clip in result["frames"][0]["reactions"].values())
        self.assertAlmostEqual(total, -9.81 * 0.187 * 0.01, places=4)
        self.assertIn("mesh", [capture["kind"] for capture in self.json("capture", "list")["captures"]])

    def test_a_mesh_too_large_for_a_request_is_sent_as_a_file(self):
        n = 61
        nodes = [f"v {0.005 * i:.6f} {0.005 * j:.6f} 0" for j in range(n) for i in range(n)]
        faces = [f"f {a} {a + 1} {a + n + 1} {a + n}" for a in
                 (j * n + i + 1 for j in range(n - 1) for i in range(n - 1))]
        text = "\n".join(nodes + faces) + "\n"
        self.assertGreater(len(text), 100000)
        (self.work / "large.obj").write_text(text)
        scene = self.scene(mesh={"kind": "file", "path": "large.obj"}, start={"place": "vertical"}, protocol=[])
        self.assertEqual(self.json("simulate", "--scene", scene)["nodes"], n * n)
        (self.work / "large.obj").write_text(text + "v 1 2\n")
        error = self.json("simulate", "--scene", scene, code=7)["error"]
        self.assertIn("scene: mesh: ", error["message"])
        (self.work / "large.obj").write_text("time,force\n")
        self.assertIn("does not begin like", self.json("simulate", "--scene", scene, code=2)["error"]["message"])

    def test_bad_scenes_are_refused_before_they_run(self):
        cases = (
            (self.scene(mesh={"kind": "grid", "nodes_u": "a", "nodes_v": 3, "length_u_m": 1, "length_v_m": 1}),
             "scene.json: mesh.nodes_u: must be a number"),
        )
        for scene, words in cases:
            for command in (("simulate", "--scene", scene), ("scene", "validate", scene)):
                error = self.json(*command, code=2)["error"]
                self.assertEqual(error["kind"], "bad_input")
                self.assertIn(words, error["message"])
        self.run_command("simulate", "--scene", "nowhere.json", code=3)
        self.run_command("simulate", code=2)
        self.run_command("simulate", "--scene", "hanging_square", "capture.h5", code=2)
        for wrong in ("weft.q=3", "weft.k=much", "weft.k=-3", "k=3", "weft.k"):
            self.assertIn("--set", self.json("simulate", "--scene", "hanging_square", "--set", wrong,
                                             code=2)["error"]["message"])
        # the daemon checks for itself
        model = json.loads(self.run_command("model", "show", "cloth_stvk").stdout)
        spec = {"schema": "tenter.job", "version": 1, "kind": "simulate", "model": model, "scene": {"schema": "x"}}
        error = self.json("job", "submit", "-", stdin=json.dumps(spec), code=2)["error"]
        self.assertIn("scene: schema: must be 'tenter.scene'", error["message"])

    def test_an_impossible_scene_fails_with_its_reason(self):
        error = self.json("simulate", "--scene", self.scene(clips=[], protocol=[]), code=7)["error"]
        self.assertIn("nothing holds it", error["message"])
        nowhere = [{"id": "left", "nodes": {"box_m": [[5, 5], [6, 6]]}}]
        error = self.json("simulate", "--scene", self.scene(clips=nowhere, protocol=[]), code=7)["error"]
        self.assertIn("clips[0].nodes: no node of the mesh is chosen", error["message"])

    def test_what_was_reached_is_delivered(self):
        tear = [{"name": "closer", "frames": 2, "motions": [{"clip": "right", "move_m": [1e-4, 0, 0]}]},
                {"name": "tear", "frames": 1, "motions": [{"clip": "right", "move_m": [-0.06, 0.04, 0],
                                                           "turn_rad": [2, 0, 1]}]}]
        mesh = {"kind": "grid", "nodes_u": 9, "nodes_v": 9, "length_u_m": 0.1, "length_v_m": 0.1}
        clips = [{"id": side, "nodes": side} for side in ("left", "right")]
        scene = self.scene(protocol=tear, mesh=mesh, clips=clips, gravity_m_s2=[0, 0, 0],
                           solver={"max_iterations": 4, "most_halvings": 1})
        done = self.run_command("simulate", "--scene", scene, "-o", "part", code=7)
        self.assertIn("no equilibrium was found for frame 3", done.stderr)
        self.assertIn("3 frames before it are kept", done.stderr)
        self.assertEqual(len(json.loads(self.folder("part")["result.json"])["frames"]), 3)
        self.assertTrue(self.folder("part")["frames.h5"].startswith(MAGIC))
        error = self.json("simulate", "--scene", scene, code=7)["error"]
        self.assertEqual(error["kind"], "job_failed")

    def test_cancel_in_the_middle(self):
        long = [{"name": "slow", "frames": 3000, "motions": [{"clip": "right", "move_m": [-0.1, 0, 0]}]}]
        mesh = {"kind": "grid", "nodes_u": 40, "nodes_v": 40, "length_u_m": 0.5, "length_v_m": 0.5}
        job = self.json("simulate", "--scene", self.scene(protocol=long, mesh=mesh), "--detach")["job_id"]
        watch = self.start("job", "watch", job)
        self.wait_for(lambda: "slow, frame" in json.dumps(self.json("job", "show", job).get("progress")),
                      "the walk is under way")
        self.assertEqual(self.json("job", "cancel", job)["state"], "cancelled")
        _, errors = watch.communicate(timeout=20)
        self.assertEqual(watch.returncode, 8, errors)
        # the only worker is free again
        self.run_command("simulate", "--scene", "table_edge")


if __name__ == "__main__":
    cli_support.main()
