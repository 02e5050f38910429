#!/bin/sh
# A sweep as an array of a Slurm cluster, a hundred jobs a task:
#   proveout sweep plan tests/sweep --output out/slot
#   sbatch --array=1-8 examples/sweep/slurm.sh out/slot 8
# then, when all have ended: proveout sweep merge out/slot
# Tasks that were preempted are sent again with the same call: jobs that have a result are not run again.
#SBATCH --job-name=proveout-sweep
#SBATCH --cpus-per-task=4
#SBATCH --mem=4G
#SBATCH --time=02:00:00
#SBATCH --requeue
set -eu
sweep=$1
parts=$2
exec proveout sweep run "$sweep" --part "$SLURM_ARRAY_TASK_ID/$parts" --threads "$SLURM_CPUS_PER_TASK"
