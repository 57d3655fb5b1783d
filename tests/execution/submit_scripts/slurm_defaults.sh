#!/bin/bash

#SBATCH --job-name=parsl.graincal-1.block-0
#SBATCH --output=/campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.stdout
#SBATCH --error=/campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.stderr
#SBATCH --nodes=1
#SBATCH --time=60
#SBATCH --ntasks-per-node=1
#SBATCH --no-requeue
#SBATCH --exclusive





export JOBNAME="parsl.graincal-1.block-0"

exec the-workers

# submitted by: sbatch /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0
