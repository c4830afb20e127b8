#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Opens the report of the fixture in headless Chromium, through chromedriver's HTTP interface:
no console message, no request but the page itself, every figure drawn; keeps screenshots.

    chromium_test.py FIXTURE_PAGE_PROGRAM OUTPUT_FOLDER
"""
import base64
import json
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request


class Browser:
    """One chromedriver process with one session; used as a context."""

    def __init__(self, dark):
        self.dark = dark

    def __enter__(self):
        self.profile = tempfile.mkdtemp(prefix="tenter-chromium-")
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        self.driver = subprocess.Popen(["/usr/bin/chromedriver", f"--port={port}"],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.base = f"http://127.0.0.1:{port}"
        self.session = None
        try:
            self._start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def _start(self):
        for _ in range(100):
            try:
                if self.call("GET", "/status")["ready"]:
                    break
            except OSError:
                time.sleep(0.1)
        arguments = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic",
                     "--no-first-run", "--disable-background-networking",
                     "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
                     "--window-size=1280,900", f"--user-data-dir={self.profile}"]
        if self.dark:
            arguments.append("--blink-settings=preferredColorScheme=0")
        options = {"binary": "/usr/bin/chromium", "args": arguments}
        reply = self.call("POST", "/session", {"capabilities": {"alwaysMatch": {
            "goog:chromeOptions": options,
            "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}}})
        self.session = "/session/" + reply["sessionId"]

    def __exit__(self, *_):
        try:
            if self.session:
                self.call("DELETE", self.session)
        except OSError:
            pass
        self.driver.terminate()
        self.driver.wait(10)
        shutil.rmtree(self.profile, ignore_errors=True)

    def call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.base + path, data=data, method=method,
                                         headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=60) as reply:
                return json.load(reply)["value"]
        except urllib.error.HTTPError as error:
            raise OSError(error.read().decode(errors="replace")) from error

    def open(self, path):
        self.call("POST", self.session + "/url", {"url": path.resolve().as_uri()})

    def run(self, script):
        return self.call("POST", self.session + "/execute/sync", {"script": script, "args": []})

    def log(self, kind):
        return self.call("POST", self.session + "/se/log", {"type": kind})

    def requested_urls(self):
        urls = []
        for entry in self.log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                urls.append(message["params"]["request"]["url"])
        return urls

    def screenshot(self, path):
        size = self.call("POST", self.session + "/goog/cdp/execute",
                         {"cmd": "Page.getLayoutMetrics", "params": {}})["cssContentSize"]
        shot = self.call("POST", self.session + "/goog/cdp/execute", {
            "cmd": "Page.captureScreenshot",
            "params": {"captureBeyondViewport": True, "clip": {
                "x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}}})
        path.write_bytes(base64.b64decode(shot["data"]))


FIGURES = """
return [...document.querySelectorAll("figure:not(.sheet)")].map(f => {
  const box = f.querySelector("svg.plot").getBoundingClientRect();
  const drawn = [...f.querySelectorAll(".series path")].filter(p => p.getBoundingClientRect().width > 0);
  return {width: box.width, height: box.height, paths: drawn.length};
});"""

MESHES = """
return [...document.querySelectorAll("figure svg.mesh")].map(svg => {
  const faces = [...svg.querySelectorAll(".face")].map(f => getComputedStyle(f).fill);
  return {width: svg.getBoundingClientRect().width, faces: faces.length, colours: new Set(faces).size,
          arrows: svg.querySelectorAll(".arrow").length};
});"""

SCENE = """
const figure = document.querySelector("#figure svg"), box = figure.getBoundingClientRect();
const seen = element => { const b = element.getBoundingClientRect(); return b.width > 0 && b.height > 0; };
return {width: box.width, height: box.height,
        facets: [...figure.querySelectorAll("path[color]")].filter(seen).length,
        lines: [...figure.querySelectorAll(".series path")].filter(seen).length,
        rows: document.querySelectorAll("#numbers tbody tr").length,
        ink: getComputedStyle(document.querySelector("#numbers td")).color,
        paper: getComputedStyle(document.querySelector("#numbers .panel")).backgroundColor};"""

TOGGLE = """
const figure = document.querySelector("figure");
const key = figure.querySelector('.keys button[data-shows="measured unload"]');
const seen = () => [...figure.querySelectorAll(".measured.unload")]
  .filter(g => g.tagName === "g" && getComputedStyle(g).display !== "none").length;
const before = seen(); key.click(); const hidden = seen(); key.click();
return [before, hidden, seen()];"""

HOVER = """
const svg = document.querySelector("figure svg.plot"), box = svg.getBoundingClientRect();
svg.dispatchEvent(new PointerEvent("pointermove", {bubbles: true,
  clientX: box.x + box.width / 2, clientY: box.y + box.height / 2}));
return document.querySelector("figure .readout").textContent;"""


def check(condition, what):
    if not condition:
        raise SystemExit(f"FAILED: {what}")


def check_page(browser, page, expected=12):
    browser.call("POST", browser.session + "/url", {"url": "about:blank"})
    browser.log("performance")  # what the browser's own start page loaded
    browser.log("browser")
    browser.open(page)
    messages = [m for m in browser.log("browser") if "favicon" not in m["message"]]
    check(not messages, f"console messages: {messages}")
    urls = browser.requested_urls()
    check(urls == [page.resolve().as_uri()], f"requests other than the page: {urls}")
    figures = browser.run(FIGURES)
    check(len(figures) == expected, f"{len(figures)} figures, expected {expected}")
    for figure in figures:
        check(figure["width"] > 300 and figure["height"] > 150 and figure["paths"] >= 2,
              f"a figure is empty: {figure}")
    overflow = browser.run("return document.documentElement.scrollWidth - innerWidth")
    check(overflow <= 0, f"the page is {overflow} px wider than the window")


def check_sheet_page(browser, page):
    check_page(browser, page, 5)
    top = browser.run("return document.querySelector('#captures tbody tr:last-child').getBoundingClientRect().top")
    check(top < 900, f"the table of captures does not fit the first screen: {top}")
    meshes = browser.run(MESHES)
    check(len(meshes) == 3, f"{len(meshes)} sheets, expected 3")
    for mesh in meshes:
        check(mesh["width"] > 300 and mesh["faces"] == 128 and mesh["colours"] >= 5 and mesh["arrows"] == 1,
              f"a sheet is not drawn: {mesh}")


def check_scene_page(browser, page):
    check_page(browser, page, 0)
    seen = browser.run(SCENE)
    check(seen["width"] > 500 and seen["height"] > 400 and seen["facets"] == 2 and seen["lines"] == 2,
          f"the figure of the scene is not drawn: {seen}")
    check(seen["rows"] == 2 and seen["ink"] != seen["paper"], f"the numbers cannot be read: {seen}")


def main():
    program, out = sys.argv[1], pathlib.Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    page, hostile, sheet = out / "report.html", out / "report-hostile.html", out / "sheet.html"
    scene = out / "scene.html"
    subprocess.run([program, str(page)], check=True)
    subprocess.run([program, str(hostile), "--hostile"], check=True)
    subprocess.run([program, str(sheet), "--sheet"], check=True)
    subprocess.run([program, str(scene), "--scene"], check=True)

    with Browser(dark=False) as browser:
        check_page(browser, page)
        first_screen = browser.run(
            "return document.querySelector('#captures tbody tr').getBoundingClientRect().top")
        check(first_screen < 900, f"the captures start below the first screen: {first_screen}")
        before, hidden, after = browser.run(TOGGLE)
        check(before == after == 5 and hidden == 0, f"legend key: {before} {hidden} {after}")
        readout = browser.run(HOVER)
        check("," in readout, f"no values under the pointer: '{readout}'")
        browser.run("document.querySelector('svg.plot').dispatchEvent(new Event('pointerleave'))")
        browser.screenshot(out / "report.png")
        check_page(browser, hostile)
        check_sheet_page(browser, sheet)
        browser.screenshot(out / "sheet.png")
        check_scene_page(browser, scene)
        browser.screenshot(out / "scene.png")
    with Browser(dark=True) as browser:
        check_page(browser, page)
        browser.screenshot(out / "report-dark.png")
        check_scene_page(browser, scene)
    for shot in ("report.png", "report-dark.png", "sheet.png"):
        check((out / shot).stat().st_size > 50_000, f"{shot} is nearly empty")
    print(f"report checked in Chromium; screenshots in {out}")


if __name__ == "__main__":
    main()
