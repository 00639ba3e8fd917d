#!/bin/sh
# A study as an array of Slurm jobs: sbatch slurm.sh /shared/study
# Shards are shared out, so the array may have any size. To resume, submit it again.
#SBATCH --job-name=trolley-study
#SBATCH --array=0-63
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --requeue
set -eu
exec python3 -m trolley_av.study "$1" --shard "$SLURM_ARRAY_TASK_ID" --of "$SLURM_ARRAY_TASK_COUNT"
