#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Starts a Slurm cluster of two nodes on this machine, runs a command that submits jobs to it, and stops it:
#   tools/two_slurm_nodes.sh sbatch --wait job.sh
# Needs root and, on Debian, the packages slurm-wlm and munge. Exit status 77 if the cluster cannot be started.
# /etc/slurm is neither read nor written.
set -eu

[ $# -gt 0 ] || { echo "usage: $0 COMMAND...   (a command that calls sbatch, srun or salloc)" >&2; exit 2; }
for program in slurmctld slurmd munged unshare; do
  PATH=$PATH:/usr/sbin:/sbin
  command -v "$program" >/dev/null || { echo "$0: $program is missing (Debian: slurm-wlm munge); no program was run" >&2; exit 77; }
done
[ "$(id -u)" = 0 ] || { echo "$0: needs root; no program was run" >&2; exit 77; }

dir=$(mktemp -d)
host=$(hostname)
stop() {
  for pid in "$dir"/*.pid; do [ ! -f "$pid" ] || kill "$(cat "$pid")" 2>/dev/null || :; done
  for _ in 1 2 3 4 5 6 7 8 9 10; do
    alive=
    for pid in "$dir"/*.pid; do [ ! -f "$pid" ] || ! kill -0 "$(cat "$pid")" 2>/dev/null || alive=yes; done
    [ -n "$alive" ] || break
    sleep 0.5
  done
  rm -rf "$dir"
}
trap stop EXIT
trap 'exit 130' INT TERM

mkdir "$dir/state" "$dir/spool.node1" "$dir/spool.node2" "$dir/pmix" "$dir/munge"
chmod 0711 "$dir" "$dir/munge"
head -c 1024 /dev/urandom > "$dir/munge.key"
chmod 0600 "$dir/munge.key"
munged --force --key-file="$dir/munge.key" --socket="$dir/munge/socket" --pid-file="$dir/munged.pid" \
  --log-file="$dir/munged.log" --seed-file="$dir/munge.seed"
# One port per daemon, below the range of ephemeral ports.
port() { awk -v p="$$" -v k="$1" 'BEGIN { print 10000 + (p * 7 + k) % 20000 }'; }
cat > "$dir/slurm.conf" <<CONF
ClusterName=here
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(port 0)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$dir/munge/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.%n.pid
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool.%n
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.%n.log
SchedulerType=sched/builtin
SelectType=select/linear
ReturnToService=2
NodeName=node1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$(port 1) CPUs=1 State=UNKNOWN
NodeName=node2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$(port 2) CPUs=1 State=UNKNOWN
PartitionName=main Nodes=node1,node2 Default=YES MaxTime=INFINITE State=UP
CONF
echo "PMIxCliTmpDirBase=$dir/pmix" > "$dir/mpi.conf"
export SLURM_CONF="$dir/slurm.conf"
slurmctld -c
# PMIx uses the same file names on each node, so each gets its own folder through a mount namespace.
for node in node1 node2; do
  unshare --mount sh -c 'mount -t tmpfs none "$1" && exec slurmd -N "$2"' sh "$dir/pmix" "$node" || {
    echo "$0: cannot start the nodes; no program was run" >&2
    exit 77
  }
done
tries=0
until [ "$(sinfo --noheader --states=idle --format=%D 2>/dev/null)" = 2 ]; do
  tries=$((tries + 1))
  if [ $tries -gt 60 ]; then
    tail -n 3 "$dir"/*.log >&2
    echo "$0: the nodes did not become idle; no program was run" >&2
    exit 77
  fi
  sleep 0.5
done
status=0
"$@" || status=$?
[ $status = 0 ] || tail -n 3 "$dir"/slurm*.log >&2
exit $status
