#!/usr/bin/env python3
"""Trains on a capture of more photographs than are kept in memory: photograph_memory.py VESTA SCENE WORK
    [--views=100] [--width=2016] [--iterations=60] [--mib=0,600,150]

Makes the capture in WORK of a COLMAP scene (sparse/0/images.bin): its photographs made --width pixels wide by
ffmpeg, its views one after the other until there are --views, each a file of its own (a hard link). Trains with
--photographs_mib of each of --mib (0: all in memory) and prints what memory was foreseen and what was taken, and the
sha256 of the splat, which must be one."""
import argparse
import hashlib
import json
import os
import pathlib
import shutil
import struct
import subprocess


def read_images(path):
    """(bytes of id, pose and camera; name; bytes of the image's points) of each image of an images.bin"""
    data = path.read_bytes()
    at, images = 8, []
    for _ in range(struct.unpack_from("<Q", data)[0]):
        head = data[at + 4 : at + 64]
        end = data.index(0, at + 64)
        points = struct.unpack_from("<Q", data, end + 1)[0]
        images.append((head, data[at + 64 : end].decode()))
        at = end + 9 + 24 * points
    return images


def make_capture(scene, work, views, width):
    capture = work / "capture"
    shutil.rmtree(capture, ignore_errors=True)
    (capture / "images").mkdir(parents=True)
    (capture / "sparse/0").mkdir(parents=True)
    (work / "large").mkdir(exist_ok=True)
    for name in ("cameras.bin", "points3D.bin"):
        shutil.copyfile(scene / "sparse/0" / name, capture / "sparse/0" / name)
    images = read_images(scene / "sparse/0/images.bin")
    for _, name in images:
        subprocess.run(
            ["ffmpeg", "-v", "error", "-y", "-i", scene / "images" / name, "-vf", f"scale={width}:-2", "-q:v", "2"]
            + [work / "large" / name],
            check=True,
        )
    out = struct.pack("<Q", views)
    for i in range(views):
        head, name = images[i % len(images)]
        copy = f"{i // len(images):03}_{name}"
        os.link(work / "large" / name, capture / "images" / copy)
        out += struct.pack("<I", i + 1) + head + copy.encode() + b"\0" + struct.pack("<Q", 0)
    (capture / "sparse/0/images.bin").write_bytes(out)
    return capture


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("vesta")
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("work", type=pathlib.Path)
    parser.add_argument("--views", type=int, default=100)
    parser.add_argument("--width", type=int, default=2016)
    parser.add_argument("--iterations", type=int, default=60)
    parser.add_argument("--mib", default="0,600,150")
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    capture = make_capture(arguments.scene, arguments.work, arguments.views, arguments.width)
    print("| photographs_mib | foreseen, MiB | taken, MiB | Adam, s | all, s | sha256 of the splat |")
    print("|---|---|---|---|---|---|")
    for mib in arguments.mib.split(","):
        out = arguments.work / f"out_{mib}"
        kept = "1e9" if mib == "0" else mib
        command = [arguments.vesta, "train", capture, f"--out={out}", f"--iterations={arguments.iterations}"]
        command += ["--seed=1", "--noreport", f"--photographs_mib={kept}", "--set", "adam.evaluations=1"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        metrics = json.loads((out / "metrics.json").read_text())
        digest = hashlib.sha256((out / "point_cloud.ply").read_bytes()).hexdigest()
        memory, seconds = metrics["memory"], metrics["seconds"]
        print(
            f"| {'all' if mib == '0' else mib} | {memory['predicted_mib']:.0f} | {memory['peak_mib']:.0f} |"
            f" {seconds['adam']:.0f} | {seconds['total']:.0f} | {digest[:12]} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
