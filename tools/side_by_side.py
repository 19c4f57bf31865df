"""Runs commands beside each other, longest first, and shows how far each is.

    python tools/side_by_side.py --logs build/tests "Blender 4.5=.venv/bin/python -m pytest -q tests/blender" …

At most two at a time (--jobs): a Blender without a window keeps one core busy. Each writes to a log of its own; what
ended well is told in its last line, what failed is shown whole. Exit code 1 if any failed.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

TOLD_EVERY_S = 30.0


@dataclass
class Job:
    name: str
    command: list[str]
    log: Path
    process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        with self.log.open("wb") as stream:
            self.process = subprocess.Popen(
                self.command, stdout=stream, stderr=subprocess.STDOUT, start_new_session=True
            )

    def stop(self) -> None:
        """It and what it started."""
        if self.process is not None and self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGTERM)

    def text(self) -> str:
        return self.log.read_text(encoding="utf-8", errors="replace")

    def share(self) -> str:
        """How far it is, as pytest says it at the end of a line: ' [ 41%]'."""
        told = re.findall(r"\[ *(\d+)%\]", self.text())
        return f"{told[-1]} %" if told else "begun"


def say(sentence: str) -> None:
    print(f"\033[1m[togishi]\033[0m {sentence}", flush=True)


def job_of(text: str, logs: Path) -> Job:
    name, equals, command = text.partition("=")
    if not (name and equals and command):
        raise argparse.ArgumentTypeError(f"{text!r}: NAME=COMMAND is wanted")
    file = re.sub(r"\W+", "-", name.lower()) + ".log"
    return Job(name, shlex.split(command), logs / file)


def run(jobs: list[Job], at_once: int) -> list[Job]:
    """The jobs that failed."""
    waiting, running, failed = list(jobs), [], []
    told = time.monotonic()
    try:
        while waiting or running:
            while waiting and len(running) < at_once:
                job = waiting.pop(0)
                job.start()
                running.append(job)
                say(f"{job.name}: begun")
            time.sleep(0.2)
            for job in [job for job in running if job.process and job.process.poll() is not None]:
                running.remove(job)
                if job.process and job.process.returncode == 0:
                    say(f"{job.name}: {(job.text().strip().splitlines() or ['done'])[-1]}")
                else:
                    failed.append(job)
                    print(job.text(), flush=True)
                    say(f"{job.name} FAILED; its output is above and in {job.log}")
            if running and time.monotonic() - told > TOLD_EVERY_S:
                told = time.monotonic()
                say(", ".join(f"{job.name} {job.share()}" for job in running))
    finally:
        for job in running:
            job.stop()
    return failed


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--logs", type=Path, required=True, help="folder of the logs")
    parser.add_argument("--jobs", type=int, default=2, help="how many at once")
    parser.add_argument("commands", nargs="+", metavar="NAME=COMMAND")
    options = parser.parse_args()
    options.logs.mkdir(parents=True, exist_ok=True)
    try:
        jobs = [job_of(text, options.logs) for text in options.commands]
    except argparse.ArgumentTypeError as error:
        parser.error(str(error))
    failed = run(jobs, max(options.jobs, 1))
    if failed:
        say(f"failed: {', '.join(job.name for job in failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
