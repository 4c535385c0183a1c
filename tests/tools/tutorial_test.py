#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""tools/tutorial.sh without COLMAP.

  tutorial_test.py missing SCRIPT BUILD_DIR    it names Debian's package, fails and writes nothing
  tutorial_test.py given SCRIPT BUILD_DIR      with the ray tracer's cameras it writes a report and a splat
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile


def tutorial(script, build_dir, out, *flags):
    """Runs the script with only a few common programs in PATH, without colmap and ffmpeg."""
    with tempfile.TemporaryDirectory() as programs:
        for name in ("cat", "cp", "date", "mkdir", "mv", "sh", "tail"):
            os.symlink(f"/bin/{name}", pathlib.Path(programs) / name)
        return subprocess.run(["/bin/sh", script, build_dir, str(out), *flags], env={"PATH": programs},
                              capture_output=True, text=True)


def missing(script, build_dir, out):
    done = tutorial(script, build_dir, out)
    assert done.returncode == 1, done
    assert done.stderr.count("\n") == 1 and "install Debian's package colmap" in done.stderr, done.stderr
    assert not out.exists()


def given(script, build_dir, out):
    done = tutorial(script, build_dir, out, "--quick", "--given_cameras")
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert "No ffmpeg" in done.stdout, done.stdout
    metrics = json.loads((out / "result/metrics.json").read_text(encoding="utf-8"))
    psnr = metrics["test"]["psnr"]
    assert psnr > 24, psnr
    for name in ("result/report.html", "result/point_cloud.ply"):
        assert (out / name).stat().st_size > 10000, name
    again = tutorial(script, build_dir, out, "--quick", "--given_cameras")
    assert again.returncode == 1 and "exists; give an OUT_DIR" in again.stderr, again


def main():
    case, script, build_dir = sys.argv[1:4]
    with tempfile.TemporaryDirectory() as folder:
        {"missing": missing, "given": given}[case](script, build_dir, pathlib.Path(folder) / "out")


main()
