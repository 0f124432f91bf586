#!/bin/sh
# Starts or stops Slurm with one node on the loopback interface, without systemd. munged, slurmctld
# and slurmd run as the calling user, with configuration, key, state and logs in one folder.
# Debian packages: slurm-wlm munge.
#
#     tests/scale/slurm-one-node.sh start DIR     prints the SLURM_CONF to export
#     tests/scale/slurm-one-node.sh stop DIR
set -eu

usage() {
    echo "usage: $0 start|stop DIR" >&2
    exit 2
}

# Succeeds if the process with the id in a file is running.
alive() {
    [ -s "$1" ] && kill -0 "$(cat "$1")" 2>/dev/null
}

stop() {
    for daemon in slurmd slurmctld munged; do
        pid_file=$dir/$daemon.pid
        if alive "$pid_file"; then
            pid=$(cat "$pid_file")
            kill "$pid"
            for _ in $(seq 100); do
                kill -0 "$pid" 2>/dev/null || break
                sleep 0.1
            done
        fi
    done
}

fail() {
    echo "$0: $1; the last lines of the logs:" >&2
    tail -n 5 "$dir"/*.log >&2
    stop
    exit 1
}

# Waits up to 20 s until a command succeeds.
wait_for() {
    for _ in $(seq 100); do
        "$@" >/dev/null 2>&1 && return
        sleep 0.2
    done
    fail "timeout: $*"
}

idle() {
    sinfo --noheader --format=%t | grep -qx idle
}

start() {
    for daemon in munged slurmctld slurmd; do
        if alive "$dir/$daemon.pid"; then
            echo "$0: $daemon runs already, see $dir/$daemon.pid" >&2
            exit 1
        fi
    done
    user=$(id -un)
    host=$(hostname -s)
    memory=$(awk '/^MemTotal/ { print int($2 / 1024 * 0.9) }' /proc/meminfo)
    # munged refuses folders into which others can write.
    umask 077
    mkdir -p "$dir/state" "$dir/spool"
    [ -s "$dir/munge.key" ] || dd if=/dev/urandom of="$dir/munge.key" bs=128 count=1 2>/dev/null

    cat >"$dir/slurm.conf" <<CONF
ClusterName=one
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=${SLURMCTLD_PORT:-6817}
SlurmdPort=${SLURMD_PORT:-6818}
# Listen on the address given above and below, not on all.
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$dir/munge.socket
CredType=cred/munge
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool
SlurmctldPidFile=$dir/slurmctld.pid
SlurmdPidFile=$dir/slurmd.pid
SlurmctldLogFile=$dir/slurmctld.log
SlurmdLogFile=$dir/slurmd.log
# Tracks processes by their parents, because cgroups may be unavailable.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
# Several tasks share the node, each with its own processors.
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=$memory State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
    export SLURM_CONF="$dir/slurm.conf"

    munged --key-file="$dir/munge.key" --socket="$dir/munge.socket" --pid-file="$dir/munged.pid" \
        --log-file="$dir/munged.log" --seed-file="$dir/munged.seed" || fail "munged does not start"
    wait_for munge --socket="$dir/munge.socket" --no-input
    slurmctld || fail "slurmctld does not start"
    wait_for scontrol ping
    slurmd || fail "slurmd does not start"
    wait_for idle
    echo "export SLURM_CONF=$SLURM_CONF"
}

[ $# = 2 ] || usage
mkdir -p "$2"
dir=$(cd "$2" && pwd)
case $1 in
start) start ;;
stop) stop ;;
*) usage ;;
esac
