#!/bin/bash

#SBATCH --job-name=parsl.graincal-1.block-0
#SBATCH --output=/campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.stdout
#SBATCH --error=/campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.stderr
#SBATCH --nodes=2
#SBATCH --time=120
#SBATCH --ntasks-per-node=1
#SBATCH --no-requeue
#SBATCH --constraint=avx512
#SBATCH --partition=fast
#SBATCH --account=soil
#SBATCH --qos=short
#SBATCH --mem=32g
#SBATCH --cpus-per-task=16

module load yade
export PARSL_MEMORY_GB=32
export PARSL_CORES=16


export JOBNAME="parsl.graincal-1.block-0"

set -e
export CORES=$SLURM_CPUS_ON_NODE
export NODES=$SLURM_JOB_NUM_NODES

[[ "1" == "1" ]] && echo "Found cores : $CORES"
[[ "1" == "1" ]] && echo "Found nodes : $NODES"
WORKERCOUNT=2
SCRIPT_DIR="/campaign/parsl/000/submit_scripts"
[[ -d $SCRIPT_DIR ]] || SCRIPT_DIR=""

cat << SLURM_EOF > ${SCRIPT_DIR:+$SCRIPT_DIR/}cmd_$SLURM_JOB_NAME.sh
exec the-workers
SLURM_EOF
chmod a+x ${SCRIPT_DIR:+$SCRIPT_DIR/}cmd_$SLURM_JOB_NAME.sh

srun --ntasks 2 -l --cpus-per-task=16 bash ${SCRIPT_DIR:+$SCRIPT_DIR/}cmd_$SLURM_JOB_NAME.sh

[[ "1" == "1" ]] && echo "Done"


# submitted by: sbatch /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0
