#!/usr/bin/env python3
"""What `--refine_cameras=all` makes of a lens whose coefficients are wrong: wrong_lens.py VESTA DISTORT_SCENE SCENE WORK
    [--coefficients=-0.1,0.02] [--factors=1,0.5,0] [--methods=none,pose,all] [--seeds=0] [--json=FILE]
    [-- flags of vesta train]

Bends the photographs of SCENE by these radial coefficients (distort_scene), states them as their k1 and k2 times a
factor, and trains. Off: the 90th percentile and the most, over the directions that the photograph shows, of the pixels
between where the lens as stated, or as found (the model that the training writes), sees them and where the true one
does; the best scale and shift of all directions apart, since depth and turns of cameras make up for these. PSNR: of the
test views with their cameras fitted, as `vesta eval --align=pose` has it, undistorted as stated or as found."""
import argparse
import json
import pathlib
import shutil
import struct
import subprocess
import sys

import numpy

OPENCV, PARAMETERS = 4, 8


def stated(source, target, factor):
    """A copy of the scene whose lens has so many times the radial coefficients."""
    shutil.rmtree(target, ignore_errors=True)
    (target / "sparse").mkdir(parents=True)
    (target / "images").symlink_to((source / "images").resolve())
    shutil.copytree(source / "sparse" / "0", target / "sparse" / "0")
    path = target / "sparse" / "0" / "cameras.bin"
    data = bytearray(path.read_bytes())
    head = struct.calcsize("<Q")
    (count,) = struct.unpack_from("<Q", data)
    size = struct.calcsize(f"<iiQQ{PARAMETERS}d")
    for k in range(count):
        camera = list(struct.unpack_from(f"<iiQQ{PARAMETERS}d", data, head + k * size))
        assert camera[1] == OPENCV
        # All zero would be a pinhole, whose photographs nobody has to undistort.
        camera[8], camera[9] = (factor * value or 1e-9 for value in camera[8:10])
        struct.pack_into(f"<iiQQ{PARAMETERS}d", data, head + k * size, *camera)
    path.write_bytes(data)
    return lens_of_binary(data)


def lens_of_binary(data):
    """(width, height, fx, fy, cx, cy, radial k1 to k6, tangential) of the first camera"""
    values = struct.unpack_from(f"<iiQQ{PARAMETERS}d", data, struct.calcsize("<Q"))
    return values[2], values[3], values[4:8], (*values[8:10], 0, 0, 0, 0), values[10:12]


def lens_of_text(path):
    line = [line for line in path.read_text().splitlines() if not line.startswith("#")][0].split()
    assert line[1] == "FULL_OPENCV"
    p = [float(value) for value in line[4:]]
    return int(line[2]), int(line[3]), p[:4], (*p[4:6], *p[8:12]), p[6:8]


def project(lens, x, y):
    _, _, (fx, fy, cx, cy), k, (p1, p2) = lens
    r2 = x * x + y * y
    scale = (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]))) / (1 + r2 * (k[3] + r2 * (k[4] + r2 * k[5])))
    u = x * scale + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * scale + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)
    return numpy.stack([fx * u + cx, fy * v + cy])


def off(lens, truth):
    width, height, (fx, fy, cx, cy), *_ = truth
    reach = numpy.linspace(-1, 1, 101)
    x, y = numpy.meshgrid(reach * 1.3 * max(cx, width - cx) / fx, reach * 1.3 * max(cy, height - cy) / fy)
    u, v = project(truth, x, y)
    seen = (u >= 0) & (u <= width) & (v >= 0) & (v <= height)
    x, y = x[seen], y[seen]
    wanted = project(truth, x, y).ravel()
    gauge = numpy.array([1.0, 0, 0])  # scale and shift of directions
    gap = lambda g: project(lens, g[0] * x + g[1], g[0] * y + g[2]).ravel() - wanted
    for _ in range(10):
        step = 1e-6
        jacobian = numpy.stack([(gap(gauge + step * unit) - gap(gauge)) / step for unit in numpy.eye(3)], 1)
        gauge -= numpy.linalg.lstsq(jacobian, gap(gauge), rcond=None)[0]
    distances = numpy.hypot(*gap(gauge).reshape(2, -1))
    return float(numpy.percentile(distances, 90)), float(distances.max())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("vesta", "distort_scene", "scene", "work"):
        parser.add_argument(name, type=pathlib.Path)
    parser.add_argument("--coefficients", default="-0.1,0.02")
    parser.add_argument("--factors", default="1,0.5,0")
    parser.add_argument("--methods", default="none,pose,all")
    parser.add_argument("--seeds", default="0")
    parser.add_argument("--json", type=pathlib.Path)
    own, _, flags = " ".join(sys.argv[1:]).partition(" -- ")
    arguments, flags = parser.parse_args(own.split()), flags.split()
    work = arguments.work
    subprocess.run([arguments.distort_scene, arguments.scene, work,
                    f"--coefficients={arguments.coefficients},0,0"], check=True, stdout=subprocess.DEVNULL)
    distorted = work / "distorted"
    truth = lens_of_binary((distorted / "sparse" / "0" / "cameras.bin").read_bytes())
    rows = []
    print(f"{'factor':>6} {'seed':>4} {'cameras':>8} {'off 90 %':>9} {'most':>6} {'PSNR':>6} {'seconds':>8}")
    for factor in map(float, arguments.factors.split(",")):
        scene = work / f"stated_{factor:g}"
        lens = stated(distorted, scene, factor)
        for seed in arguments.seeds.split(","):
            for method in arguments.methods.split(","):
                out = work / f"out_{factor:g}_{method}_{seed}"
                shutil.rmtree(out, ignore_errors=True)
                subprocess.run([arguments.vesta, "train", scene, f"--out={out}", f"--refine_cameras={method}",
                                f"--seed={seed}", "--noreport", *flags], check=True, stdout=subprocess.DEVNULL)
                as_found = lens
                shown = scene
                if method == "all":
                    as_found = lens_of_text(out / "cameras" / "cameras.txt")
                    shown = work / "as_found"
                    shutil.rmtree(shown, ignore_errors=True)
                    (shown / "sparse").mkdir(parents=True)
                    (shown / "images").symlink_to((distorted / "images").resolve())
                    shutil.copytree(out / "cameras", shown / "sparse" / "0")
                judged = out / "eval.json"
                splat = next(out.glob("*.ply"))
                subprocess.run([arguments.vesta, "eval", splat, shown, "--align=pose", f"--json={judged}"], check=True,
                               stdout=subprocess.DEVNULL)
                most = off(as_found, truth)
                row = {"factor": factor, "seed": seed, "method": method, "off_90": most[0], "off_most": most[1],
                       "psnr_aligned": json.loads(judged.read_text())["aligned"]["psnr"],
                       "seconds": json.loads((out / "metrics.json").read_text())["seconds"]["total"]}
                rows.append(row)
                print(f"{factor:6g} {seed:>4} {method:>8} {most[0]:9.3f} {most[1]:6.3f} {row['psnr_aligned']:6.2f} "
                      f"{row['seconds']:8.1f}", flush=True)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
