# SPDX-License-Identifier: GPL-3.0-or-later
"""A real daemon on its own store and DDS domain, and the real command, for the cli_*_test.py beside this file."""
import argparse
import fcntl
import json
import os
import pathlib
import pty
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import termios
import time
import unittest

PROGRAMS = argparse.Namespace()


def main():
    """Takes the programs from the command line, the rest is unittest's."""
    parser = argparse.ArgumentParser()
    for name in ("tenter", "tenterd", "worker", "data"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--artefacts")
    parser.add_argument("--sheets")
    parser.add_argument("--friction-tables")
    rest = parser.parse_known_args(namespace=PROGRAMS)[1]
    for name in ("tenter", "tenterd", "worker", "data"):
        setattr(PROGRAMS, name, os.path.abspath(getattr(PROGRAMS, name)))
    unittest.main(module="__main__", argv=[sys.argv[0]] + rest, verbosity=2)


def free_domain():
    """A number and the socket whose name keeps it, as tests/common/wire/domain.h does."""
    for number in range(60, 231):
        lock = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        try:
            lock.bind(f"\0tenter-test-domain-{number}")
            return number, lock
        except OSError:
            lock.close()
    raise RuntimeError("no DDS domain is free")


class Daemon:
    def __init__(self, workers=2):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="tenter-cli-"))
        self.domain, self.lock = free_domain()
        self.workers = workers
        self.process = None
        self.start()

    def start(self):
        ready = self.folder / "ready"
        ready.unlink(missing_ok=True)
        log = open(self.folder / "tenterd.log", "a")
        self.process = subprocess.Popen(
            [PROGRAMS.tenterd, "--store", str(self.folder / "store"), "--domain", str(self.domain),
             "--workers", str(self.workers), "--worker", PROGRAMS.worker, "--ready-file", str(ready)],
            stdout=log, stderr=log)
        log.close()
        deadline = time.monotonic() + 30
        while not ready.exists():
            if self.process.poll() is not None or time.monotonic() > deadline:
                raise RuntimeError("tenterd is not ready: " + self.log())
            time.sleep(0.02)

    def log(self):
        return (self.folder / "tenterd.log").read_text(errors="replace")

    def kill(self):
        self.process.kill()
        self.process.wait()

    def close(self):
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(15)
            except subprocess.TimeoutExpired:
                self.kill()
        self.lock.close()
        shutil.rmtree(self.folder, ignore_errors=True)


class CommandTest(unittest.TestCase):
    """One daemon for all tests of a class; `self.work` is an empty folder that the commands run in."""
    workers = 2

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(cls.workers)

    @classmethod
    def tearDownClass(cls):
        cls.daemon.close()

    def setUp(self):
        started = time.monotonic()
        self.addCleanup(lambda: print(f"({time.monotonic() - started:.1f} s) ", end="", file=sys.stderr, flush=True))
        self.work = pathlib.Path(tempfile.mkdtemp(dir=self.daemon.folder))

    def environment(self, user):
        return dict(os.environ, TENTER_DOMAIN=str(self.daemon.domain), TENTER_USER=user, TERM="xterm", COLUMNS="100")

    def start(self, *arguments, user="ada", **options):
        return subprocess.Popen([PROGRAMS.tenter, *map(str, arguments)], cwd=self.work, env=self.environment(user),
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)

    def run_command(self, *arguments, user="ada", code=0, stdin=None, timeout=120):
        done = subprocess.run([PROGRAMS.tenter, *map(str, arguments)], cwd=self.work, env=self.environment(user),
                              input=stdin, capture_output=True, text=True, timeout=timeout)
        self.assertEqual(done.returncode, code, f"tenter {' '.join(map(str, arguments))}\n{done.stdout}\n{done.stderr}")
        return done

    def json(self, *arguments, **options):
        """The one JSON value on standard output."""
        return json.loads(self.run_command("--json", *arguments, **options).stdout)

    def capture(self, name="acrylic_rib_x"):
        """A shipped capture, imported into the work folder."""
        data = pathlib.Path(PROGRAMS.data) / "knit"
        self.run_command("capture", "import", data / f"{name}.csv", "--describe", data / f"{name}.json",
                         "-o", f"{name}.h5")
        return self.work / f"{name}.h5"

    def wait_for(self, condition, what, seconds=20):
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if condition():
                return
            time.sleep(0.05)
        self.fail("never: " + what)


def on_terminal(command, environment, folder, seconds=60):
    """Runs a command on a terminal of its own: exit code and everything it wrote."""
    child, terminal = pty.fork()
    if child == 0:
        os.chdir(folder)
        os.execve(command[0], command, environment)
    fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 100, 0, 0))
    written = b""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        readable, _, _ = select.select([terminal], [], [], 0.2)
        if not readable:
            continue
        try:
            piece = os.read(terminal, 65536)
        except OSError:
            break
        if not piece:
            break
        written += piece
    else:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    os.close(terminal)
    return os.waitstatus_to_exitcode(status), written.decode(errors="replace")
