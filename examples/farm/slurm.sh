#!/bin/sh
# One picture in parts as a Slurm array, merged after the last. Prints the number of the job that merges.
#
#   slurm.sh SCENE OUT.exr PARTS [options of lobes render]
#
# A part whose node fails is queued again. Where a part fails, the merge does not run: `scontrol requeue JOB_PART` repeats it.
set -eu
scene=$1 out=$2 parts=$3
shift 3
lobes=${LOBES:-lobes}
folder=$out.parts
mkdir -p "$folder"
array=$(sbatch --parsable --requeue --array="1-$parts" --output="$folder/%a.log" --job-name=lobes <<JOB
#!/bin/sh
exec "$lobes" render "$scene" --quiet --threads "\${SLURM_CPUS_PER_TASK:-1}" --tiles "\$SLURM_ARRAY_TASK_ID/$parts" -o "$folder/\$SLURM_ARRAY_TASK_ID.exr" $*
JOB
)
sbatch --parsable --dependency="afterok:$array" --output="$folder/merge.log" --job-name=lobes-merge <<JOB
#!/bin/sh
set -e
"$lobes" merge "$folder"/*.exr -o "$out" --quiet
rm -r "$folder"
JOB
