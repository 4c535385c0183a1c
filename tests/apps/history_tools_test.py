# SPDX-License-Identifier: Apache-2.0
"""The demo's table, plot and contact sheet for a made-up run. Usage: history_tools_test.py table|plot

Exit status 77, which ctest reports as skipped, if the plot cannot be tested because matplotlib is missing."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"
sys.path.insert(0, str(TOOLS))
sys.dont_write_bytecode = True


def row(stage, iteration, seconds, cost, psnr):
    return {"stage": stage, "iteration": iteration, "seconds": seconds, "cost": cost, "train_psnr": psnr + 1,
            "train_ssim": 0.9, "test_psnr": psnr, "test_ssim": psnr / 40, "gaussians": 1000 + iteration}


ROWS = [row("adam", 0, 0.5, 0.3, 12.0), row("adam", 500, 20.25, 0.05, 24.0), row("adam", 1000, 40.25, 0.04, 26.0),
        row("lm", 0, 40.25, 0.04, 26.0), row("lm", 1, 50.5, 0.033, 27.5), row("lm", 2, 61.5, 0.03, 28.0)]


class FileCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.metrics = self.folder / "metrics.json"
        self.metrics.write_text(json.dumps({"test": {}, "history": ROWS}))

    def run_tool(self, name, *arguments):
        command = [sys.executable, "-B", str(TOOLS / name), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, check=False)


class TableTest(FileCase):
    def test_last_row_of_each_stage(self):
        result = self.run_tool("history_table.py", self.metrics)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = [line.split() for line in result.stdout.splitlines()]
        self.assertEqual(len(lines), 3)
        self.assertEqual(lines[1], ["Adam", "1000", "40.2", "26.00", "0.6500", "27.00", "2000"])
        self.assertEqual(lines[2], ["LM", "2", "61.5", "28.00", "0.7000", "29.00", "1002"])

    def test_run_without_adam(self):
        self.metrics.write_text(json.dumps({"history": ROWS[3:]}))
        result = self.run_tool("history_table.py", self.metrics)
        self.assertEqual([line.split()[0] for line in result.stdout.splitlines()], ["stage", "LM"])

    def test_bad_files_are_refused_in_one_line(self):
        for text in ("", "[]", "{}", '{"history": []}', '{"history": [{"stage": "adam"}]}', '{"history": [3]}'):
            self.metrics.write_text(text)
            result = self.run_tool("history_table.py", self.metrics)
            self.assertEqual(result.returncode, 1, text)
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            self.assertIn("metrics.json", result.stderr)
        self.assertIn("No such file", self.run_tool("history_table.py", self.folder / "none.json").stderr)


class PlotTest(FileCase):
    def test_curves_are_the_history(self):
        import plot_history
        cost, psnr = plot_history.draw(ROWS).axes
        for axes, count in ((cost, 1), (psnr, 2)):
            lines = axes.get_lines()
            self.assertEqual(len(lines), 2 * count)
            self.assertEqual(list(lines[0].get_xdata()), [0.5, 20.25, 40.25])
            self.assertEqual(list(lines[count].get_xdata()), [40.25, 50.5, 61.5])
        self.assertEqual(list(cost.get_lines()[0].get_ydata()), [0.3, 0.05, 0.04])
        self.assertEqual(list(cost.get_lines()[1].get_ydata()), [0.04, 0.033, 0.03])
        self.assertEqual(list(psnr.get_lines()[2].get_ydata()), [26.0, 27.5, 28.0])
        self.assertEqual(list(psnr.get_lines()[3].get_ydata()), [27.0, 28.5, 29.0])

    def test_plot_is_written(self):
        from matplotlib import image
        plot = self.folder / "plot.png"
        result = self.run_tool("plot_history.py", self.metrics, plot)
        self.assertEqual(result.returncode, 0, result.stderr)
        pixels = image.imread(plot)
        self.assertGreater(pixels.shape[1], 800)
        self.assertGreater(pixels.std(), 0.05)  # something is drawn
        self.assertEqual(sorted(path.name for path in self.folder.iterdir()), ["metrics.json", "plot.png"])

    def test_contact_sheet_stacks_images(self):
        import numpy
        from matplotlib import image
        names = []
        for value in (0.2, 0.8):
            names.append(self.folder / f"{value}.png")
            image.imsave(names[-1], numpy.full((3, 5, 3), value))
        result = self.run_tool("contact_sheet.py", self.folder / "sheet.png", *names)
        self.assertEqual(result.returncode, 0, result.stderr)
        pixels = image.imread(self.folder / "sheet.png")
        self.assertEqual(pixels.shape[:2], (6, 5))
        self.assertAlmostEqual(float(pixels[:3, :, :3].mean()), 0.2, delta=0.005)
        self.assertAlmostEqual(float(pixels[3:, :, :3].mean()), 0.8, delta=0.005)
        other = self.folder / "other.png"
        image.imsave(other, numpy.zeros((2, 5, 3)))
        result = self.run_tool("contact_sheet.py", self.folder / "bad.png", names[0], other)
        self.assertEqual(result.returncode, 1)
        self.assertFalse((self.folder / "bad.png").exists())


if __name__ == "__main__":
    case = {"table": TableTest, "plot": PlotTest}[sys.argv[1]]
    if case is PlotTest:
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            print(f"skipped: {sys.executable} has no matplotlib (Debian: python3-matplotlib)")
            sys.exit(77)
    outcome = unittest.TextTestRunner().run(unittest.defaultTestLoader.loadTestsFromTestCase(case))
    sys.exit(not outcome.wasSuccessful())
