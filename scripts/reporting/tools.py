# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the programs and keeps what they say."""
import hashlib
import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import time
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
BIN = ROOT / "build/release/bin"


@dataclass
class Campaign:
    """What is measured, how thoroughly, and where results go."""
    folder: pathlib.Path
    quick: bool
    scenes: dict  # name: description
    data: dict = field(default_factory=dict)  # all numbers, for report.json
    key: str = ""  # of programs, scenes and thoroughness
    seconds: float = 0  # of measuring, whenever it was done
    plans: dict = field(default_factory=dict)

    def __post_init__(self):
        self.settings = self.choose({"reach_photons": 2**20}, {})  # of every bake
        parts = [str(self.quick).encode()]
        parts += [path.read_bytes() for path in (BIN / "bake", BIN / "viewer", *self.scenes.values())]
        parts += [path.read_bytes() for d in self.scenes.values() for path in sorted(d.parent.glob("*.glb"))]
        self.key = hashlib.sha256(b"".join(parts)).hexdigest()

    def choose(self, quick, full):
        return quick if self.quick else full

    def once(self, name, measure):
        """What measure() gives, or gave in an earlier run by the same programs on the same scenes."""
        path = self.folder / "data" / f"{name}.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        if known.get("key") != self.key:
            start = time.monotonic()
            known = {"key": self.key, "value": measure()}
            known["seconds"] = time.monotonic() - start
            write_json(path, known)
            known = json.loads(path.read_text())  # as it will be read again
        self.data[name] = known["value"]
        self.seconds += known.get("seconds", 0)
        return known["value"]

    def plan(self, description):
        if description not in self.plans:
            self.plans[description] = run_json("bake", "plan", description, "--json", *settings_options(self.settings))
        return self.plans[description]

    def described(self, description):
        """Photons per position, positions and cells of a scene as it is described."""
        plan = self.plan(description)
        lamps = len([l for l in description.read_text().splitlines() if l.strip() == "[[light]]"])
        return {"photons": plan["photons_total"] // plan["light_samples"], "samples": plan["light_samples"] // lamps,
                "cells": max(plan["grid"])}

    def work(self, name):
        path = self.folder / "work" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        return path


def write_json(path, value):
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    part.write_text(json.dumps(value, indent=1) + "\n")
    os.replace(part, path)


def say(text):
    print(f"[{time.strftime('%H:%M:%S')}] {text}", flush=True)


def run(program, *arguments, check=True):
    command = [str(BIN / program), *map(str, arguments), "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    if check and done.returncode:
        sys.exit(f"{' '.join(command)}\nfailed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def run_json(program, *arguments):
    return json.loads(run(program, *arguments))


def run_measured(program, *arguments):
    """Seconds and peak memory (bytes) of a process of its own."""
    command = [str(BIN / program), *map(str, arguments), "--quiet"]
    start = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    problem = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.monotonic() - start
    if status:
        sys.exit(f"{' '.join(command)}\nfailed:\n{problem[-2000:]}")
    return seconds, usage.ru_maxrss * 1024


def settings_options(settings):
    return [word for key, value in settings.items() for word in ("--set", f"{key}={json.dumps(value)}")]


def bake(campaign, name, description, **settings):
    """A map, baked if it is not there. Returns the file."""
    target = campaign.work(f"{name}.vdb")
    if not target.exists():
        say(f"baking {name}")
        run("bake", "run", description, "-o", target, *settings_options(campaign.settings | settings))
    return target


def bake_seconds(map_file):
    return json.loads((map_file.with_name(map_file.name + ".work") / "run.json").read_text())["bake_seconds"]


def view(map_file, picture, *options):
    """A picture, and what the viewer says of it."""
    stats = picture.with_suffix(".json")
    run("viewer", map_file, "--output", picture, "--stats", stats, *options)
    return json.loads(stats.read_text())


def half_width(values):
    """Of the 95 % interval of the mean (Student's t)."""
    t = {2: 12.71, 3: 4.303, 4: 3.182, 5: 2.776}.get(len(values), 2.3)
    return t * statistics.stdev(values) / len(values) ** 0.5 if len(values) > 1 else 0.0


def description_with(description, target, changes):
    """A copy of a description beside nothing: its geometry by absolute path, `changes` as (pattern, replacement)."""
    text = re.sub(r'^geometry = "', f'geometry = "{description.parent}/', description.read_text(), flags=re.M)
    for pattern, replacement in changes:
        text, count = re.subn(pattern, replacement, text, flags=re.M)
        if not count:
            raise ValueError(f"{description}: nothing matches {pattern}")
    target.write_text(text)
    return target


def machine():
    """What the numbers were measured on."""
    cpu = next((line.split(":", 1)[1].strip() for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines()
                if line.startswith("model name")), "unknown")
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    git = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty"], capture_output=True, text=True)
    release = pathlib.Path("/etc/os-release")
    system = re.search(r'PRETTY_NAME="(.*)"', release.read_text()) if release.exists() else None
    return {"processor": cpu, "cores": os.cpu_count(), "memory": f"{memory:.0f} GiB",
            "system": system.group(1) if system else "unknown", "version": run("bake", "--version").strip(),
            "commit": git.stdout.strip() or "unknown", "date": time.strftime("%Y-%m-%d"),
            "vector unit": "the widest that the processor has"}


def has(program):
    return shutil.which(program) is not None


