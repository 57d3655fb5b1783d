#!/bin/bash

#PBS -S /bin/bash
#PBS -N parsl.graincal-1.block-0
#PBS -m n
#PBS -l walltime=02:00:00
#PBS -l select=1:ncpus=16:mem=32gb
#PBS -o /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.stdout
#PBS -e /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0.stderr
#PBS -r n
#PBS -l place=excl

module load yade

export JOBNAME="parsl.graincal-1.block-0"

exec the-workers


# submitted by: qsub -q fast -A soil /campaign/parsl/000/submit_scripts/parsl.graincal-1.block-0
