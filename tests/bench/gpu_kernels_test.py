# SPDX-License-Identifier: Apache-2.0
"""bench/gpu's gpu_kernels, built for an emulated device, on a workload of a few tiles: it completes, agrees with the
host and reports the targets of a GPU run.

Usage: gpu_kernels_test.py PROGRAM"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv.pop(1)


class GpuKernels(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "report.json"
            cls.process = subprocess.run(
                [PROGRAM, "--gaussians", "150", "--pixels", "1000", "--views", "2", "--repeats", "1", "--json", path],
                capture_output=True, text=True, check=False)
            cls.report = json.loads(path.read_text()) if path.exists() else {}

    def test_agrees_with_the_host_and_itself(self):
        self.assertEqual(self.process.returncode, 0, self.process.stdout + self.process.stderr)
        targets = {t["name"]: t for t in self.report["targets"]}
        for name in ["image", "J v", "J^T u"]:
            target = targets[f"{name}, relative difference to the host"]
            self.assertTrue(target["met"] and target["value"] > 0, target)
        self.assertEqual(targets["values that differ between two runs"]["value"], 0)

    def test_counts_launches_and_waits(self):
        rows = {row["pass"]: row for row in self.report["rows"]}
        # For the number of visible splats, of pairs, and the cost.
        self.assertEqual(rows["Adam iteration"]["waits"], 3)
        self.assertEqual((rows["J v"]["launches"], rows["J v"]["waits"]), (2, 0))
        self.assertEqual((rows["J^T u"]["launches"], rows["J^T u"]["waits"]), (4, 0))
        self.assertGreater(rows["LM iteration, all views"]["launches"], 8 * 2 * 7)
        self.assertGreater(rows["LM iteration, all views"]["ms"], 0)

    def test_probe_names_the_device(self):
        probe = subprocess.run([PROGRAM, "--probe", "yes"], capture_output=True, text=True, check=False)
        self.assertEqual(probe.returncode, 0)
        self.assertTrue(probe.stdout.startswith("emulated, "), probe.stdout)


if __name__ == "__main__":
    unittest.main()
