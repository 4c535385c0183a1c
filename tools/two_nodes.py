#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs an MPI program on two simulated nodes, to test what happens between machines without a second machine. The nodes
are network namespaces of this machine with their own host names, joined by a virtual link. Needs root, iproute2 and Open MPI.

  tools/two_nodes.py [--processes 2] [--gbit G] [--latency_ms L] [--mca NAME=VALUE ...] -- PROGRAM ...

Processes alternate between the nodes. With --gbit or --latency_ms this script forwards the packets between the nodes and delays them
like a link with this bandwidth and one-way latency; at most a few Gbit/s are possible. The exit status is that of the program, or 77
with a one-line reason if this machine does not allow network namespaces.
"""
import argparse
import contextlib
import fcntl
import os
import queue
import shutil
import signal
import stat
import struct
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

CANNOT = 77
# Unique to this run.
NODES = (f"vesta-{os.getpid()}-a", f"vesta-{os.getpid()}-b")
DEVICES = (f"v{os.getpid()}a", f"v{os.getpid()}b")
ADDRESSES = ("10.77.0.1", "10.77.0.2")
# Large packets, for speed.
MTU = 16000


def ip(*words):
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True)


class Direction:
    """One direction of the link: a packet is sent after the previous one, and arrives after the latency."""

    def __init__(self, source, target, bytes_a_second, latency):
        self._source, self._target = source, target
        self._bytes_a_second, self._latency = bytes_a_second, latency
        self._under_way = queue.Queue()
        for work in (self._take, self._deliver):
            threading.Thread(target=work, daemon=True).start()

    def _take(self):
        free = 0.0
        while packet := self._read():
            now = time.monotonic()
            free = max(free, now) + (len(packet) / self._bytes_a_second if self._bytes_a_second else 0)
            self._under_way.put((free + self._latency, packet))

    def _read(self):
        try:
            return os.read(self._source, 1 << 16)
        except OSError:  # the node was deleted
            return b""

    def _deliver(self):
        with contextlib.suppress(OSError):
            while True:
                arrives, packet = self._under_way.get()
                time.sleep(max(0.0, arrives - time.monotonic()))
                os.write(self._target, packet)


def open_tap(name):
    set_interface, tap_without_header = 0x400454CA, 0x0002 | 0x1000
    device = os.open("/dev/net/tun", os.O_RDWR)
    fcntl.ioctl(device, set_interface, struct.pack("16sH", name.encode(), tap_without_header))
    return device


def join_nodes(gbit, latency_ms):
    """Joins the nodes: by a pair of virtual devices, or by two taps between which this script forwards packets."""
    if gbit or latency_ms:
        ends = [open_tap(device) for device in DEVICES]
        for device, node in zip(DEVICES, NODES):
            ip("link", "set", device, "netns", node)
    else:
        ends = []
        ip("link", "add", DEVICES[0], "netns", NODES[0], "type", "veth", "peer", "name", DEVICES[1], "netns", NODES[1])
    for device, node, address in zip(DEVICES, NODES, ADDRESSES):
        ip("-n", node, "addr", "add", f"{address}/24", "dev", device)
        ip("-n", node, "link", "set", device, "mtu", str(MTU))
        ip("-n", node, "link", "set", device, "up")
        ip("-n", node, "link", "set", "lo", "up")
    for source, target in zip(ends, ends[::-1]):
        Direction(source, target, gbit * 1e9 / 8, latency_ms * 1e-3)


def leave_nodes():
    for node in NODES:
        subprocess.run(["ip", "netns", "delete", node], capture_output=True, check=False)


def on_node(node, *words):
    """The command line that runs `words` on a node with its own host name, so that MPI uses the link between the nodes."""
    return ["ip", "netns", "exec", node, "unshare", "--uts", "sh", "-c", f'hostname {node}; exec "$@"', "sh", *words]


def write_agent(folder):
    """Writes the script that mpirun runs instead of ssh to start processes on the other node: AGENT ADDRESS COMMAND..."""
    agent = Path(folder) / "agent"
    enter = " ".join(on_node(NODES[1])[:6])
    agent.write_text(f'#!/bin/sh\nshift\nexec {enter} sh -c "hostname {NODES[1]}; $*"\n')
    agent.chmod(agent.stat().st_mode | stat.S_IXUSR)
    return agent


def run(processes, settings, program):
    with tempfile.TemporaryDirectory() as folder:
        hosts = Path(folder) / "hosts"
        hosts.write_text("".join(f"{address} slots={(processes + 1 - k) // 2}\n" for k, address in enumerate(ADDRESSES)))
        network = f"{ADDRESSES[0]}/24"
        mpirun = ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", str(processes), "--map-by", "node",
                  "--hostfile", str(hosts), "--mca", "plm_rsh_agent", str(write_agent(folder)), "--mca", "btl", "tcp,self",
                  "--mca", "btl_tcp_if_include", network, "--mca", "oob_tcp_if_include", network]
        for setting in settings:
            mpirun += ["--mca", *setting.split("=", 1)]
        return subprocess.run(on_node(NODES[0], *mpirun, *program), check=False).returncode


def why_not():
    """Returns the missing requirement, or "" if nothing is missing."""
    for tool in ("ip", "unshare", "mpirun"):
        if not shutil.which(tool):
            return f"{tool} is missing"
    if "Open MPI" not in subprocess.run(["mpirun", "--version"], capture_output=True, text=True, check=False).stdout:
        return "mpirun is not from Open MPI"
    return "" if os.geteuid() == 0 else "network namespaces need root"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--gbit", type=float, default=0.0)
    parser.add_argument("--latency_ms", type=float, default=0.0)
    parser.add_argument("--mca", action="append", default=[], help="MCA parameter of Open MPI")
    parser.add_argument("program", nargs="+")
    args = parser.parse_args()
    if why := why_not():
        print(f"two_nodes.py: {why}; no program was run", file=sys.stderr)
        return CANNOT
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # so that the nodes are deleted
    try:
        for node in NODES:
            ip("netns", "add", node)
        join_nodes(args.gbit, args.latency_ms)
    except (subprocess.CalledProcessError, OSError) as error:
        why = (getattr(error, "stderr", None) or str(error)).strip()
        print(f"two_nodes.py: cannot create network namespaces ({why}); no program was run", file=sys.stderr)
        leave_nodes()
        return CANNOT
    try:
        return run(args.processes, args.mca, args.program)
    finally:
        leave_nodes()


if __name__ == "__main__":
    sys.exit(main())
