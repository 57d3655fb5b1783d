#!/bin/bash

#PBS -S /bin/bash
#PBS -N parsl.graincal-1.block-0
#PBS -m n
#PBS -l walltime=01:00:00
#PBS -l select=1:ncpus=8
#PBS -o /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.stdout
#PBS -e /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.stderr
#PBS -r n



export JOBNAME="parsl.graincal-1.block-0"

exec the-workers


# submitted by: qsub /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0
