#!/usr/bin/env bash
# Tries sweep.sbatch on a SLURM of one node that it starts itself and stops again, under a folder of its own: an array is
# killed and requeued in mid sweep, collected, and compared with the sweep of a single process.
# Needs root and Debian's packages: apt-get install --no-install-recommends slurm-wlm munge
# Usage: try.sh path/to/tackscope
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
tackscope=$(realpath "$1")
work=$(mktemp -d)
daemons=()
clean_up() {
    scancel --name=sweep 2>/dev/null || true
    for pid in "${daemons[@]}"; do kill "$pid" 2>/dev/null || true; done
    wait || true
    rm -rf "$work"
}
trap clean_up EXIT

ports=(17817 17818)
export SLURM_CONF=$work/slurm.conf
export PATH=$(dirname "$tackscope"):$PATH
mkdir -p "$work"/{state,spool,munge}
chmod 755 "$work"
dd if=/dev/urandom of="$work/munge/key" bs=1024 count=1 status=none
chmod 700 "$work/munge"; chmod 400 "$work/munge/key"
# No cgroups: a container may not have them to give away.
cat >"$SLURM_CONF" <<CONF
ClusterName=try
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=root
SlurmctldPort=${ports[0]}
SlurmdPort=${ports[1]}
AuthType=auth/munge
AuthInfo=socket=$work/socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
MpiDefault=none
MinJobAge=3600
SchedulerParameters=batch_sched_delay=0,sched_interval=2,sched_min_interval=100000
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
NodeName=$(hostname -s) NodeAddr=127.0.0.1 CPUs=2
PartitionName=all Nodes=ALL Default=YES State=UP
CONF
munged --foreground --force --socket="$work/socket" --key-file="$work/munge/key" --pid-file="$work/munge/pid" \
    --seed-file="$work/munge/seed" --log-file="$work/munge/log" 2>"$work/munged.log" & daemons+=($!)
for _ in $(seq 50); do [[ -S $work/socket ]] && break; sleep 0.1; done
slurmctld -D 2>/dev/null & daemons+=($!)
slurmd -D 2>/dev/null & daemons+=($!)
for _ in $(seq 100); do [[ $(sinfo -h -o %t 2>/dev/null) == idle ]] && break; sleep 0.3; done
[[ $(sinfo -h -o %t) == idle ]] || { echo "no node came up:"; tail -5 "$work"/*.log; exit 1; } >&2
echo "SLURM $(slurmd -V) is up: $(sinfo -h -o '%N %t %c CPUs')"

cat >"$work/study.toml" <<'STUDY'
format = 1
scene = "fig2"
record = ["dissipated_energy", "predicted_error", "jumps", "approach_jumps", "retraction_jumps", "transforms"]
[set]
cell.points = 48
[[axis]]
key = "law.range"
linear = { from = 0.9, to = 1.3, count = 12 }
[[axis]]
key = "cell.length"
values = [220.0, 240.0, 256.0, 270.0]
STUDY
rows() { cat "$work"/array/shard-*/sweep.csv 2>/dev/null | grep -vc '^row,' || true; }
states() { squeue -h -r -j "$job" -t all -o '%K %T' | sort -n | tr '\n' ';'; }

job=$(sbatch --parsable --array=1-4 --output="$work/task-%a.log" "$here/sweep.sbatch" "$work/study.toml" "$work/array")
for _ in $(seq 600); do (($(rows) >= 6)) && break; sleep 0.1; done
echo "in mid sweep: $(rows) of 48 rows; $(states)"
# One task is killed as a node that dies kills it, one is requeued as a scheduler does.
killed=$(squeue -h -r -j "$job" -t running -o %K | sort -n | head -1)
requeued=$(squeue -h -r -j "$job" -t running -o %K | sort -n | tail -1)
id=$(squeue -h -r -j "$job" -t running -o '%K %A' | awk -v task="$killed" '$1 == task { print $2 }')
pid=$(scontrol listpids "$id" | awk 'NR > 1 && $1 > 0 { print $1 }' | while read -r p; do
    [[ $(cat "/proc/$p/comm") == tackscope ]] && echo "$p"; done || true)
kill -9 $pid
[[ $requeued == "$killed" ]] || scontrol requeue "${job}_$requeued"
for _ in $(seq 100); do squeue -h -r -j "$job" -t failed -o %K | grep -qx "$killed" && break; sleep 0.1; done
echo "task $killed killed with signal 9, task $requeued requeued: $(rows) rows; $(states)"
if tackscope sweep "$work/study.toml" --out "$work/array" --collect --quiet; then echo "nothing is missing already" >&2; fi
scontrol requeue "${job}_$killed"
for _ in $(seq 3000); do
    [[ -z $(squeue -h -r -j "$job" -t pending,running,completing,requeued -o %K) ]] && break
    sleep 0.2
done
echo "at the end: $(rows) rows; $(states)"
cat "$work"/task-*.log
tackscope sweep "$work/study.toml" --out "$work/array" --collect
echo "now in one process"
tackscope sweep "$work/study.toml" --out "$work/single" --quiet
cmp "$work/array/sweep.csv" "$work/single/sweep.csv"
doubled=$(cut -d, -f1 "$work"/array/shard-*/sweep.csv | grep -v row | sort | uniq -d | wc -l)
[[ $doubled == 0 && $(rows) == 48 ]]
echo "nothing lost, nothing doubled: 48 rows, equal to the last byte"
